"""The pictures of analyses, one module each with ``draw(dataset)``."""
