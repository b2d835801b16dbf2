"""Pictures and sentences: they draw and phrase what other rooms computed, and compute nothing
themselves.
"""
