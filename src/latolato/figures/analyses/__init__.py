"""The pictures of the analyses, one module for each, by the name of the analysis."""
