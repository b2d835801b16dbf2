"""The paper's pushes on its four materials, recorded and simulated: what is known of them, runs
that stand for them, and the figures and tables of both.
"""
