"""The paper's figures and tables, and those it lacks: each computes in one function and draws in
another.
"""
