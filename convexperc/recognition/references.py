"""From pictures to recognition: references prepared once, then each set of views recognised against them."""

import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Unpack

import numpy as np
from jaxtyping import Float, UInt8

from convexperc.errors import (
    FeatureError,
    FileFormatError,
    ImageError,
    InputError,
    PictureWarning,
    TemplateNameError,
    check_type,
)
from convexperc.features.configuration import FeatureConfiguration
from convexperc.features.extraction import describe
from convexperc.features.folders import Folder
from convexperc.features.pictures import Channels, Picture, as_rgb, is_flat, list_images, read_image
from convexperc.features.recent import RecentFeatures
from convexperc.files import placed
from convexperc.problem.column_files import open_columns
from convexperc.problem.library import TemplateLibrary
from convexperc.problem.modalities import Modalities
from convexperc.recognition.frames import Frames, Regions, Seen
from convexperc.recognition.label import Options, recognize
from convexperc.recognition.recognition import Recognition

NamedPictures = Mapping[str, UInt8[np.ndarray, "_ _ 3"]]
"""Pictures by name, each of its own size."""
ReferencePictures = Mapping[str, UInt8[np.ndarray, "_ _ 3"] | NamedPictures]
"""The picture of each object, or its pictures by name."""


@dataclass(frozen=True, eq=False)
class References:
    """The known objects, one picture or several each, as columns of features.

    Attributes
    ----------
    library : TemplateLibrary
        At least two objects; column j of its O describes the reference ``names[j]``.
    configuration : FeatureConfiguration
        How the library was made, and how the views will be described.
    recent : RecentFeatures
        The views of the last call of `perceive`: one whose pixels have not changed is not described again.
    """

    library: TemplateLibrary
    configuration: FeatureConfiguration
    recent: RecentFeatures = field(default_factory=RecentFeatures, repr=False)

    def __post_init__(self) -> None:
        check_type(self.library, TemplateLibrary, "library")
        check_type(self.configuration, FeatureConfiguration, "configuration", FeatureError)

    @classmethod
    def of(
        cls,
        pictures: ReferencePictures,
        configuration: FeatureConfiguration,
        channels: Channels = "RGB",
    ) -> "References":
        """Describe each object's pictures.

        Parameters
        ----------
        pictures : mapping of str to uint8 (h, w, 3), or to a mapping of str to such pictures
            Each object's name and picture, or its pictures by their own names; see `as_rgb` for other forms.
        configuration : FeatureConfiguration
        channels : {"RGB", "BGR"}
            Order of the channels of all pictures: "BGR" for those that OpenCV has read.

        Warns
        -----
        PictureWarning
            Pictures that show nothing: whose red, green and blue each vary by at most `FLAT_RANGE` of 255.

        Raises
        ------
        InputError
            Fewer than two objects: the only one would be recognised in any view.
        TemplateNameError
            An object without a picture; a name that another reference has.
        ImageError
            A picture cannot be used; the reference is named.
        """
        check_type(pictures, Mapping, "references")
        if len(pictures) < 2:
            must = "must show at least two objects"
            remedy = "With one there is nothing to tell it from: it would be recognised in any view."
            raise InputError("references", value=list(pictures), must=must, remedy=remedy)
        shown, names, parts = list[str](), list[str](), list[Picture]()
        for name, picture in pictures.items():
            own = picture if isinstance(picture, Mapping) else {"": picture}
            if not own:
                must = "must have at least one picture"
                raise TemplateNameError(f"references of {name!r}", value=own, must=must)
            for reference, part in own.items():
                shown.append(name)
                names.append(f"{name}/{reference}" if reference else name)
                parts.append(part)
        named = zip(names, parts, strict=True)
        rgb = (as_rgb(part, f"the picture of reference {name!r}", channels) for name, part in named)
        columns = describe(rgb, configuration).T
        columns.flags.writeable = False
        flat = [name for name, part in zip(names, parts, strict=True) if is_flat(part)]
        if flat:
            said = f"of one color are the references {', '.join(flat)}: they show nothing"
            warnings.warn(said, PictureWarning, stacklevel=2)
        library = TemplateLibrary(
            columns, names=names, objects=None if names == shown else shown,
            modalities=configuration.modality_sizes,
        )  # fmt: skip
        return cls(library, configuration)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "References":
        """Open references that `save` wrote; see `TemplateLibrary.load`.

        Raises
        ------
        FileFormatError
            It is not readable, or holds something else; a library without the configuration of its features,
            or of others than that describes, or of fewer than two objects.
        """
        stored, file = open_columns(path), os.fspath(path)
        if "features" not in stored.more:
            must = "must hold the configuration of its features, as References.save writes it"
            raise FileFormatError(f"{file}: more", value=stored.more, must=must)
        try:
            configuration = FeatureConfiguration.from_dict(stored.more["features"])
            sizes = Modalities.of(configuration.modality_sizes, stored.modalities.d)
        except InputError as error:
            raise placed(file, error) from None
        if sizes.names != stored.modalities.names or not sizes.same(stored.modalities):
            must = "must be those of the configuration in the file"
            raise FileFormatError(f"{file}: modalities", value=stored.modalities.names, must=must)
        library = TemplateLibrary.stored(stored)
        if len(library.objects) < 2:
            must = "must name at least two objects: the only one would be recognised in any view"
            raise FileFormatError(f"{file}: objects", value=list(library.objects), must=must)
        return cls(library, configuration)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the library with its configuration to a file; see `TemplateLibrary.save`."""
        self.library.save(path, {"features": self.configuration.to_dict()})

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the references, all different."""
        return self.library.names

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects."""
        return self.library.objects

    @property
    def O(self) -> Float[np.ndarray, "d p"]:  # noqa: E743, N802 - the paper's symbol
        """Reference features, one column a reference."""
        return np.asarray(self.library.O)


def read_pictures(folder: str | os.PathLike[str]) -> NamedPictures:
    """Read all pictures of a folder, sorted by file name; each is named by its stem, whatever that holds.

    Raises
    ------
    ImageError
        The folder cannot be read or holds no picture, a picture is unsound, or two files have the same stem.
    """
    return _read(_by_stem(list_images(folder)))


def read_references(folder: str | os.PathLike[str]) -> ReferencePictures:
    """Read the pictures of each object: ``OBJECT.png``, or all of those in a sub-folder ``OBJECT``.

    Raises
    ------
    ImageError
        A folder cannot be read, there is no picture at all, a picture is unsound, or two files, or a file and
        a folder, have the same name.
    """
    found = Folder.of(folder)
    places: dict[str, Path | dict[str, Path]] = dict(_by_stem(found.pictures))
    for inner in map(Folder.of, found.folders):
        name = inner.path.name
        if inner.pictures and name in places:
            must = f"must not have the name of {places[name]}: it is the object's"
            raise ImageError(f"folder {inner.path}", value=name, must=must, remedy="Rename one of the two.")
        if inner.pictures:
            places[name] = _by_stem(inner.pictures)
    if not places:
        list_images(folder)  # says that there is none
    return {
        name: _read(place) if isinstance(place, dict) else read_image(place)
        for name, place in sorted(places.items())
    }


def read_scenes(folder: str | os.PathLike[str]) -> Iterator[tuple[str, NamedPictures]]:
    """Read labelled scenes, ``OBJECT/SCENE/*.png``: the object's name and the views of each, in order.

    Raises
    ------
    ImageError
        A folder cannot be read or holds no scene; as `read_pictures` for each scene.
    """
    objects = Folder.of(folder).folders
    scenes = [(path.name, scene) for path in objects for scene in Folder.of(path).folders]
    if not scenes:
        name, must = f"folder {os.fspath(folder)}", "must hold folders OBJECT/SCENE with pictures"
        raise ImageError(name, value=f"{len(objects)} folders", must=must, remedy="Is it the right folder?")
    for name, scene in scenes:
        yield name, read_pictures(scene)


def left_out(
    folder: str | os.PathLike[str], *, references: bool = False, scenes: bool = False
) -> tuple[str, ...]:
    """Name each entry of a folder that is not read, and say why; hidden ones are not named.

    Parameters
    ----------
    folder : path-like
    references, scenes : bool
        By which function it is read: `read_references`, `read_scenes`, or, without, `read_pictures`.

    Raises
    ------
    ImageError
        A folder cannot be read.
    """
    check_type(references, bool, "references")
    check_type(scenes, bool, "scenes")
    found = Folder.of(folder)
    said = [f"{name} ({reason})" for name, reason in found.others]
    if scenes:
        said += [f"{each.name} (a picture outside of a scene)" for each in found.pictures]
    for path in found.folders:
        if references:
            said += _left_out_of_object(Folder.of(path))
        elif scenes:
            said += _left_out_of_scenes(Folder.of(path))
        else:
            said.append(f"{path.name} (a folder)")
    return tuple(said)


def _left_out_of_object(inner: Folder) -> list[str]:
    """What is not read of the folder of one object's references."""
    name = inner.path.name
    said = [f"{name}/{entry} ({reason})" for entry, reason in inner.others]
    said += [f"{name}/{each.name} (a folder)" for each in inner.folders]
    return said if inner.pictures else [*said, f"{name} (a folder without a picture)"]


def _left_out_of_scenes(inner: Folder) -> list[str]:
    """What is not read of the folder of one object's scenes."""
    name = inner.path.name
    said = [f"{name}/{entry} ({reason})" for entry, reason in inner.others]
    said += [f"{name}/{each.name} (a picture outside of a scene)" for each in inner.pictures]
    for scene in inner.folders:
        said += [f"{name}/{scene.name}/{each}" for each in left_out(scene)]
    return said if inner.folders else [*said, f"{name} (a folder without a scene)"]


def _by_stem(paths: Iterable[Path]) -> dict[str, Path]:
    """Each file by its stem."""
    places: dict[str, Path] = {}
    for path in paths:
        if path.stem in places:
            must = f"must not have the stem of {places[path.stem].name}: it is the name"
            raise ImageError(f"picture {path}", value=path.stem, must=must, remedy="Rename one of the two.")
        places[path.stem] = path
    return places


def _read(places: Mapping[str, Path]) -> NamedPictures:
    return {name: read_image(path) for name, path in places.items()}


def perceive(
    views: Frames,
    references: References,
    *,
    lambda1: float,
    lambda2: float,
    lambda3: float,
    channels: Channels = "RGB",
    regions: Regions | None = None,
    start: Recognition | None = None,
    **options: Unpack[Options],
) -> Recognition:
    """Recognise the object that the views show.

    Parameters
    ----------
    views : mapping of str to uint8 (h, w, 3) or None, or sequence of these
        Each robot's name and frame, or frames alone, whose robots are then called ``robot 1`` and so on; see
        `as_rgb` for other forms of a frame. One view is enough. A robot whose frame is None is left out, and
        `Recognition.warnings` says so.
    references : References
        Its `recent` keeps these views and their features until the next call.
    lambda1, lambda2, lambda3, **options
        See `recognize`.
    channels : {"RGB", "BGR"}
        Order of the channels of all frames: "BGR" for those that OpenCV delivers.
    regions : mapping of str to Region or to bool or uint8 (h, w), optional
        For a robot by name, what of its frame counts: a rectangle, or a mask, whose box is cut out and made
        black where the mask is 0 (`cut_out`). The references should be cut out in the same way.
    start : Recognition, optional
        An earlier one; see `recognize`. One of another number of views, such as before a robot had a frame or
        after it has lost it, is not used, which costs iterations and changes no bound's validity.

    Returns
    -------
    Recognition
        Its `warnings` name the views that show nothing: whose red, green and blue each vary by at most
        `FLAT_RANGE` of 255.

    Raises
    ------
    InputError
        `references` are not `References`.
    FeatureError
        No view at all.
    ImageError
        No robot has a frame, or a frame or a region cannot be used; the robot is named.
    RobotNameError
        A robot that is not named by a string, or a region for a robot that is not among the views.
    ProblemError, DecisionError, ToleranceError, StartError, SolverError
        See `recognize`.
    """
    if not isinstance(references, References):
        must, remedy = "must be References", "Read a file of them by References.load(path)."
        raise InputError("references", value=references, must=must, remedy=remedy)
    seen = Seen.of(views, channels, regions)
    usable = not isinstance(start, Recognition) or len(start.views) == len(seen.names)
    found = recognize(
        describe(seen.pictures, references.configuration, references.recent),
        references.library,
        lambda1=lambda1,
        lambda2=lambda2,
        lambda3=lambda3,
        views=seen.names,
        start=start if usable else None,
        **options,
    )
    flat = [name for name, picture in zip(seen.names, seen.pictures, strict=True) if is_flat(picture)]
    said = [f"of one color are the views of {', '.join(flat)}: they show nothing"] if flat else []
    more = *seen.warnings, *said
    return replace(found, warnings=(*found.warnings, *more)) if more else found
