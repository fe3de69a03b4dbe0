"""Libraries of templates in files: what is written is what is opened, and nothing else is accepted."""

import json
import os
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from convexperc import TemplateLibrary, recognize
from convexperc.errors import FileFormatError, InputError, ProblemError, TemplateNameError
from convexperc.problem import column_files
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


def meta(**parts):
    return lambda h: h["__metadata__"].update(parts)


def tensor(**parts):
    return lambda h: h["templates"].update(parts)


DAMAGE = {
    "another schema": (meta(schema="x/1"), "__metadata__: schema must be 'convexperc/library/1'"),
    "no schema": (lambda h: h["__metadata__"].pop("schema"), "must have exactly the keys schema, names"),
    "no templates": (lambda h: h.pop("templates"), r"header must have exactly the keys .* got \['__meta"),
    "another tensor": (lambda h: h.update(more=h["templates"]), r"got \['__metadata__', 'templates', 'more"),
    "another type": (tensor(dtype="F128"), "templates: dtype must be one of F64, .* got 'F128'"),
    "a type of no string": (tensor(dtype=64), "templates: dtype must be one of .* got 64"),
    "a list for a type": (tensor(dtype=["F64"]), r"templates: dtype must be one of .* got \['F64'\]"),
    "an object for a type": (tensor(dtype={"F64": 1}), "templates: dtype must be one of .* got {'F64': 1}"),
    "a part more": (tensor(order="C"), "templates must have exactly the keys dtype, shape, data_offsets"),
    "too many": (tensor(shape=[5, 5]), r"templates: shape must fill the 160 bytes .* got \[5, 5\]"),
    "a negative size": (tensor(shape=[-4, -5]), r"shape must be two integers >= 1.* got \[-4, -5\]"),
    "no template": (tensor(shape=[0, 5]), "templates: shape must be two integers >= 1"),
    "a boolean size": (tensor(shape=[True, 20]), "templates: shape must be two integers >= 1"),
    "a huge size": (tensor(shape=[2**80, 2**80]), "templates: shape must fill"),
    "one size": (tensor(shape=[20]), "templates: shape must be two integers"),
    "nested sizes": (tensor(shape=[[4], 5]), "templates: shape must be two integers"),
    "another place": (tensor(data_offsets=[8, 160]), r"data_offsets must be \[0, 160\].* got \[8, 160\]"),
    "a place out of the file": (tensor(data_offsets=[0, 2**70]), r"data_offsets must be \[0, 160\]"),
    "a place as a number": (tensor(data_offsets=160), r"data_offsets must be \[0, 160\]"),
    "a boolean place": (tensor(data_offsets=[False, 160]), r"data_offsets must be \[0, 160\].* got \[False"),
    "a place as a float": (tensor(data_offsets=[0.0, 160.0]), r"data_offsets must be \[0, 160\].* got \[0.0"),
    "no tensor": (lambda h: h.update(templates=[1]), r"templates must be a JSON object; got \[1\]"),
    "a list of metadata": (lambda h: h.update(__metadata__=[7]), r"_ must be a JSON object; got \[7\]"),
    "metadata null": (lambda h: h.update(__metadata__=None), "__metadata__ must be a JSON object; got None"),
    "a part of the metadata more": (meta(made="now"), "__metadata__ must have exactly the keys"),
    "a schema of no string": (meta(schema=["x"]), r"__metadata__: schema must be a string; got \['x'\]"),
    "names of no string": (meta(names=["a", "b"]), r"__metadata__: names must be a string; got \['a', 'b'\]"),
    "objects of no string": (meta(objects=None), "__metadata__: objects must be a string; got None"),
    "modalities of no string": (meta(modalities={"a": 5}), "__metadata__: modalities must be a string"),
    "more of no string": (meta(more=1.5), "__metadata__: more must be a string; got 1.5"),
    "metadata of NaN": (meta(names=float("nan")), "__metadata__: names must be a string; got 'NaN'"),
    "names that do not fit": (meta(names='["a"]'), "names must name each of the 4 templates once"),
    "names twice": (meta(names='["a", "a", "b", "c"]'), "names must name each of the 4 templates once"),
    "names that are no JSON": (meta(names="["), "__metadata__: names must be a readable JSON file"),
    "a number for names": (meta(names="5"), "__metadata__: names must be null or a list of strings.* got 5"),
    "numbers for names": (meta(names="[1, 2, 3, 4]"), r"names must be null or a list of str.* got \[1, 2"),
    "an object for names": (meta(names='{"a":1,"b":1,"c":1,"d":1}'), "names must be null or a list"),
    "NaN for a name": (meta(names='["a", "b", "c", NaN]'), "names must be null or a list of strings"),
    "an empty name": (meta(names='["a", "b", "c", ""]'), "names must name each of the 4 templates once"),
    "too few objects": (meta(objects='["a"]'), "objects must name the object that each of the 4"),
    "numbers for objects": (meta(objects="[1, 1, 1, 1]"), "objects must be null or a list of strings"),
    "an object for objects": (meta(objects='{"a":1,"b":1,"c":1,"d":1}'), "objects must be null or a list"),
    "other modalities": (meta(modalities='{"a": 4}'), "modalities must sum to the 5 columns"),
    "no modalities": (meta(modalities="null"), "modalities must be a JSON object of names .* got None"),
    "a list of modalities": (meta(modalities="[2, 3]"), "modalities must be a JSON object of names"),
    "a boolean column": (meta(modalities='{"a": [false, 1], "b": [2, 3, 4]}'), "modalities must be a JSON"),
    "modalities of text": (meta(modalities='{"a": "5"}'), "modalities must be a JSON object of names"),
    "a size without end": (meta(modalities='{"a": 1e999}'), "modalities must be a JSON object of names"),
    "a huge column": (meta(modalities='{"a": [0, 18446744073709551616], "b": 1}'), "modality 'a' must be"),
    "a modality twice": (meta(modalities='{"a": 2, "a": 3}'), "modalities: key must be given once; got 'a'"),
    "a list for more": (meta(more="[1]"), r"__metadata__: more must be a JSON object; got \[1\]"),
    "null for more": (meta(more="null"), "__metadata__: more must be a JSON object; got None"),
    "NaN in more": (meta(more='{"a": [NaN]}'), r"__metadata__: more\['a'\]\[0\] must be a JSON value"),
    "too deep": (meta(more='{"a":' + "[" * 200 + "]" * 200 + "}"), r"more\['a'\]\[0\].* must be a JSON"),
    "much too deep": (meta(more="[" * 10**5), "__metadata__: more must be a readable JSON file"),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGE)
def test_a_damaged_header_is_refused(tmp_path, name):
    change, said = DAMAGE[name]
    library().save(tmp_path / "O")
    header, numbers = content(tmp_path / "O")
    change(header)
    written(tmp_path / "O", header, numbers)
    with pytest.raises(FileFormatError, match=said):
        TemplateLibrary.load(tmp_path / "O")


HEADERS = {
    "a list": (b"[1, 2]", r"header must be a JSON object; got \[1, 2\]"),
    "a string": (b'"templates"', "header must be a JSON object; got 'templates'"),
    "null": (b"null", "header must be a JSON object; got None"),
    "NaN": (b"NaN", "header must be a JSON object; got 'NaN'"),
    "a key twice": (b'{"templates": {}, "templates": {}}', "header: key must be given once; got 'templates'"),
    "no UTF-8": (b'{"\xff": 1}', "header must be a readable JSON file"),
    "nothing": (b"  ", "header must be a readable JSON file"),
    "lists in each other": (b"[" * 10**5, "header must be a readable JSON file"),
    "a number without end": (b"9" * 10**4, "header must be a readable JSON file"),
}


@pytest.mark.parametrize("name", HEADERS)
def test_a_header_that_is_none_is_refused(tmp_path, name):
    text, said = HEADERS[name]
    (tmp_path / "O").write_bytes(len(text).to_bytes(8, "little") + text)
    with pytest.raises(FileFormatError, match=said):
        TemplateLibrary.load(tmp_path / "O")


@pytest.mark.parametrize("length", [0, 1, 10**6, 2**28 + 1, 2**63, 2**64 - 1])
def test_an_absurd_length_of_the_header_is_refused(tmp_path, length):
    library().save(tmp_path / "O")
    (tmp_path / "O").write_bytes(length.to_bytes(8, "little") + (tmp_path / "O").read_bytes()[8:])
    with pytest.raises(FileFormatError, match=f"got '.* bytes, header of {length}'"):
        TemplateLibrary.load(tmp_path / "O")


@pytest.mark.parametrize("path", ["a\0b", "\ud800", None, 3, b"O", ["O"]])
def test_what_is_no_path_is_refused(untyped, path):
    with pytest.raises(FileFormatError, match="library of templates must be a path"):
        TemplateLibrary.load(path)
    with pytest.raises(InputError, match="output must be a path"):
        library().save(path)


def test_what_is_no_file_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "file").write_bytes(b"x")
    for place, said in {
        "": "no ordinary file", "pipe": "no ordinary file", "loop": "symbolic links",
        "file/O": "Not a directory", "n" * 300: "too long",
    }.items():  # fmt: skip
        with pytest.raises(FileFormatError, match=said):
            TemplateLibrary.load(tmp_path / place)


def test_a_file_that_is_shortened_while_it_is_opened_is_refused(tmp_path, monkeypatch):
    library().save(tmp_path / "O")
    before = column_files._tensor

    def cut(*given):
        os.truncate(tmp_path / "O", 100)
        return before(*given)

    monkeypatch.setattr(column_files, "_tensor", cut)
    with pytest.raises(FileFormatError, match="mmap length is greater than file size"):
        TemplateLibrary.load(tmp_path / "O")


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.integers(-5, 5) | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=8,
)
PLACES = [
    (), ("__metadata__",), ("templates",),
    *(("templates", key) for key in ("dtype", "shape", "data_offsets")),
    *(("__metadata__", key) for key in ("schema", "names", "objects", "modalities", "more")),
]  # fmt: skip


def forged(path, place, value) -> bytes:
    """A file with another value at one place of its header."""
    header, numbers = content(path)
    whole = holder = {"header": header}
    for key in ("header", *place)[:-1]:
        holder = holder[key]
    holder[("header", *place)[-1]] = value
    text = json.dumps(whole["header"]).encode()
    return len(text).to_bytes(8, "little") + text + numbers


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.sampled_from(PLACES), value=JSON, quoted=st.booleans())
def test_any_json_for_a_part_of_the_header_is_refused_or_read(tmp_path, untyped, place, value, quoted):
    if not (tmp_path / "O").exists():
        library().save(tmp_path / "O")
    path = tmp_path / "forged"
    path.unlink(missing_ok=True)
    path.write_bytes(forged(tmp_path / "O", place, json.dumps(value) if quoted else value))
    try:
        opened = TemplateLibrary.load(path)
    except FileFormatError:
        return
    assert place[:1] == ("__metadata__",)
    assert len(opened.names) == len(opened.shown) == len(set(opened.names)) == 4
    assert all(type(name) is str for name in (*opened.names, *opened.shown))
    assert sum(opened.modalities.sizes) == 5
    if place[-1] == "more":
        assert open_columns(path).more == value


def test_a_flipped_bit_of_the_header_is_refused_or_read(tmp_path, untyped):
    library().save(tmp_path / "O")
    data, numbers = (tmp_path / "O").read_bytes(), library().O.tobytes()
    for bit in range(0, 8 * (len(data) - 160), 7):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        (tmp_path / "O").unlink()
        (tmp_path / "O").write_bytes(flipped)
        with suppress(FileFormatError):
            assert TemplateLibrary.load(tmp_path / "O").O.tobytes() == numbers


@pytest.mark.parametrize(
    "name", ["日本語", "👩\u200d🚀", "\u202egnp", "line\nbreak", "byte\udce9", "\0", "a/b", '"\\', " "]
)
def test_odd_names_are_kept(tmp_path, name):
    known = TemplateLibrary({name: {name: [1.0, 2.0]}, "b": [3.0, 4.0]}, modalities={name: 2})
    known.save(tmp_path / "O", {name: [name, None, True, -0.0, 5e-324, 2**70, {}]})
    stored, opened = open_columns(tmp_path / "O"), TemplateLibrary.load(tmp_path / "O")
    assert (opened.names, opened.shown) == ((f"{name}/{name}", "b"), (name, "b"))
    assert opened.modalities.names == (name,)
    assert stored.more == {name: [name, None, True, -0.0, 5e-324, 2**70, {}]}


class Unknown:
    pass


CIRCLE = []
CIRCLE.append(CIRCLE)
UNFIT = {
    "NaN": ({"a": [float("nan")]}, r"more\['a'\]\[0\] must be a JSON value"),
    "infinity": ({"a": float("inf")}, r"more\['a'\] must be a JSON value"),
    "an object": ({"a": Unknown()}, r"more\['a'\] must be a JSON value"),
    "bytes": ({"a": b"x"}, r"more\['a'\] must be a JSON value"),
    "an array": ({"a": np.ones(2)}, r"more\['a'\] must be a JSON value"),
    "a key that is a number": ({"a": {1: 2}}, r"a key of more\['a'\] must be a string; got 1"),
    "a key of the first level": ({None: 2}, "a key of more must be a string; got None"),
    "a circle": ({"a": CIRCLE}, r"more\['a'\].* must be a JSON value"),
    "a huge integer": ({"a": 10**5000}, "more must be a JSON value"),
    "a list": ([1], r"more must be a mapping of str to JSON values; got \[1\]"),
    "a number": (5, "more must be a mapping of str to JSON values; got 5"),
    "an empty list": ([], "more must be a mapping"),
}


@pytest.mark.parametrize("name", UNFIT)
def test_what_a_file_does_not_keep_is_not_written(tmp_path, untyped, name):
    more, said = UNFIT[name]
    with pytest.raises(InputError, match=said):
        library().save(tmp_path / "O", more)
    assert not (tmp_path / "O").exists()


def test_a_header_that_would_not_be_opened_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(column_files, "MAX_HEADER", 100)
    with pytest.raises(InputError, match=r"must fit into a header of 100 bytes; got '\d+ bytes'\. Shorten"):
        library().save(tmp_path / "O")


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
