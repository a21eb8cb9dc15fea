"""The view Analyse: questions, their forms and their answers."""
