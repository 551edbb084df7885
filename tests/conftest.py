"""The order of tests."""

LONGEST = "test_path_shift.py"


def pytest_collection_modifyitems(items):
    """The longest file first: started last, it would keep one processor busy while the others wait."""
    items.sort(key=lambda item: item.path.name != LONGEST)
