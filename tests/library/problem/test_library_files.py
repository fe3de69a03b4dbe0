"""Libraries of templates in files: what is written is what is opened, and nothing else is accepted."""

import json

import numpy as np
import pytest

from convexperc import TemplateLibrary, recognize
from convexperc.errors import FileFormatError, InputError, ProblemError, TemplateNameError
from convexperc.problem.column_files import KINDS, open_columns

LAMBDAS = {"lambda1": 0.1, "lambda2": 0.1, "lambda3": 0.1}
SIZES = {"color": 2, "shape": 3}


def library() -> TemplateLibrary:
    rng = np.random.default_rng(0)
    return TemplateLibrary({"cup": rng.random((3, 5)), "bücher ☕": rng.random(5)}, modalities=SIZES)


def content(path) -> tuple[dict, bytes]:
    data = path.read_bytes()
    length = int.from_bytes(data[:8], "little")
    return json.loads(data[8 : 8 + length]), data[8 + length :]


def written(path, header, numbers) -> None:
    text = json.dumps(header).encode()
    path.write_bytes(len(text).to_bytes(8, "little") + text + numbers)


def test_what_is_opened_is_what_was_saved(tmp_path):
    known, path = library(), tmp_path / "known.safetensors"
    known.save(path, {"made": [1, 2]})
    opened = TemplateLibrary.load(path)
    assert (opened.names, opened.objects, opened.shown) == (known.names, known.objects, known.shown)
    assert opened.O.tobytes() == known.O.tobytes()
    assert isinstance(opened.O, np.memmap)
    assert opened.modalities.names == ("color", "shape")
    assert opened.modalities.same(known.modalities)
    assert open_columns(path).more == {"made": [1, 2]}
    X = np.random.default_rng(1).random((3, 5))
    one, two = (recognize(X, each, **LAMBDAS) for each in (known, opened))
    assert (one.label, one.answers.lower.tobytes()) == (two.label, two.answers.lower.tobytes())


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_keep_their_type(tmp_path, kind):
    O = np.arange(8).reshape(4, 2).astype(KINDS[kind])
    for order in ("<", ">"):
        TemplateLibrary(O.astype(O.dtype.newbyteorder(order))).save(tmp_path / "O")
        opened = TemplateLibrary.load(tmp_path / "O")
        assert (opened.O.dtype, opened.O.tolist()) == (O.dtype, O.tolist())


def test_names_and_objects_may_be_missing_and_columns_may_be_scattered(tmp_path):
    known = TemplateLibrary(np.ones((4, 3)), modalities={"a": [0, 2], "b": [1, 3]})
    known.save(tmp_path / "O")
    opened = TemplateLibrary.load(tmp_path / "O")
    assert (opened.names, opened.given_names, opened.given_objects) == (known.names, None, None)
    assert opened.modalities.same(known.modalities)


def test_the_file_has_the_layout_of_safetensors(tmp_path):
    library().save(tmp_path / "O")
    header, numbers = content(tmp_path / "O")
    assert header["templates"] == {"dtype": "F64", "shape": [4, 5], "data_offsets": [0, 160]}
    assert all(isinstance(value, str) for value in header["__metadata__"].values())
    assert np.frombuffer(numbers, "<f8").reshape(4, 5).T.tolist() == library().O.tolist()
    assert ((tmp_path / "O").stat().st_size - len(numbers)) % 64 == 0


DAMAGE = {
    "another schema": (lambda h: h["__metadata__"].update(schema="x/1"), "schema must be"),
    "no schema": (lambda h: h["__metadata__"].pop("schema"), "no 'schema'"),
    "no templates": (lambda h: h.pop("templates"), "no 'templates'"),
    "another type": (lambda h: h["templates"].update(dtype="F128"), "dtype must be one of"),
    "too many": (lambda h: h["templates"].update(shape=[5, 5]), "must be all that follows"),
    "another place": (lambda h: h["templates"].update(data_offsets=[8, 160]), "must be all that follows"),
    "a negative size": (lambda h: h["templates"].update(shape=[-4, -5]), "must be all that follows"),
    "names that do not fit": (lambda h: h["__metadata__"].update(names='["a"]'), "name each of the 4"),
    "names that are no JSON": (lambda h: h["__metadata__"].update(names="["), "readable JSON"),
    "other modalities": (lambda h: h["__metadata__"].update(modalities='{"a": 4}'), "modalities"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_a_damaged_header_is_refused(tmp_path, name):
    change, said = DAMAGE[name]
    library().save(tmp_path / "O")
    header, numbers = content(tmp_path / "O")
    change(header)
    written(tmp_path / "O", header, numbers)
    with pytest.raises(FileFormatError, match=said):
        TemplateLibrary.load(tmp_path / "O")


def test_every_shortened_or_lengthened_file_is_refused(tmp_path):
    library().save(tmp_path / "O")
    data = (tmp_path / "O").read_bytes()
    for length in (*range(0, len(data), 7), len(data) - 1):
        (tmp_path / "O").write_bytes(data[:length])
        with pytest.raises(FileFormatError):
            TemplateLibrary.load(tmp_path / "O")
    (tmp_path / "O").write_bytes(data + b"\0")
    with pytest.raises(FileFormatError):
        TemplateLibrary.load(tmp_path / "O")
    with pytest.raises(FileFormatError, match="Check the path"):
        TemplateLibrary.load(tmp_path / "missing")


def test_a_library_that_cannot_be_written_leaves_what_was_there(tmp_path, monkeypatch):
    (tmp_path / "O").write_bytes(b"old")
    monkeypatch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(InputError, match="No space left"):
        library().save(tmp_path / "O")
    assert (tmp_path / "O").read_bytes() == b"old"


def test_a_library_is_extended_by_objects_and_by_references():
    known = TemplateLibrary({"a": [1.0, 2.0], "b": [2.0, 3.0]}, modalities=[1, 1])
    more = known.extended({"a": [5.0, 6.0], "c": [[1.0, 1.0], [2.0, 2.0]]})
    assert more.names == ("a", "b", "a/2", "c/1", "c/2")
    assert more.shown == ("a", "b", "a", "c", "c")
    assert more.O.tolist() == [[1, 2, 5, 1, 2], [2, 3, 6, 1, 2]]
    assert known.names == ("a", "b")
    assert TemplateLibrary(np.ones((2, 3))).extended(np.zeros((2, 1))).names[-1] == "object 4"
    with pytest.raises(TemplateNameError, match="must name the templates that are added"):
        known.extended(np.ones((2, 1)))
    with pytest.raises(ProblemError, match="must have 2 rows"):
        known.extended(np.ones((3, 1)), names=["d"])
