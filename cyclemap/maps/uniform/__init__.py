"""The transfer operator and passages under uniform noise, whose density jumps."""
