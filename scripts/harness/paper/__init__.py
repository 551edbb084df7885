"""The evaluation of Zeng et al. 2025, figure by figure, behind scripts/reproduce.py.

A module each: `run(paper)` measures and returns a page.Section, `plan(paper)` says what will be rendered. All go
through the runner, cache and statistics of the harness; paper.Paper holds what they share.
"""
