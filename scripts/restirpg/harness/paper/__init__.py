"""The evaluation of Zeng et al. 2025, figure by figure, behind scripts/reproduce.py.

Each module measures by way of a paper.Paper, which goes through the runner, cache and statistics of the
harness, and returns a page.Section; experiments.py lists them.
"""
