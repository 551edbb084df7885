"""Every file of ../shared/inputs gives its exact value, or the refusal that it deserves: shared_inputs.csv."""

import pytest
from shared_inputs import is_right, measure, rows, shared_folder

TABLE = rows()


@pytest.fixture(autouse=True)
def needs_inputs():
    if shared_folder() is None:
        pytest.skip(
            "the inputs are missing: none is held to its exact value; set RESTIRPG_SHARED to the folder that holds inputs/"
        )


def parameter(row):
    """The row; one that is known to be wrong may fail."""
    marks = [pytest.mark.xfail(reason=row.open, strict=False)] if row.open else []
    return pytest.param(row, id=row.name, marks=marks)


@pytest.mark.parametrize("row", map(parameter, TABLE))
def test_an_input_gives_its_exact_value(row):
    value = measure(row)
    assert is_right(row, value), f"{row.quantity} {row.expected} +- {row.tolerance}: {value}"


def test_every_input_is_in_the_table():
    folder = shared_folder() / "inputs"
    files = {str(file.relative_to(folder)) for file in folder.rglob("*") if file.suffix in (".gltf", ".glb", ".hdr")}
    files |= {str(file.relative_to(folder)) for file in (folder / "exr_env").glob("*.exr")}
    files |= {str(file.relative_to(folder)) for file in (folder / "hostile").iterdir()}
    assert files == {row.input for row in TABLE}
