"""What the view Map needs of Python: stored maps, and files that the library makes.

Pages compute maps by themselves (``static/js/map``).
"""
