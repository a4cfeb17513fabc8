"""Volumes in blocks, of one process or of the ranks of an MPI communicator."""

from __future__ import annotations

import contextlib
import functools
import operator
import os
import sys
import weakref
from typing import TYPE_CHECKING, Any, Callable, Iterator, Optional, Sequence, TypeVar, cast

import numpy as np

from . import _core, _progress
from ._core import InputError
from ._image import Image
from ._table import command_line, document
from ._view import LOCAL_PAGES
from ._volume import TYPES, Volume, address_of, ascii_unit, nine, strides_of, three

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import PictureOptions

F = TypeVar("F", bound=Callable[..., Any])

_NO_MPI = (
    "this ringsplat was built for one process; hint: build it for this machine's MPI: pip install . "
    "-C cmake.define.RINGSPLAT_PYTHON_MPI=ON (docs/python.md)"
)


def _connect(comm: Any) -> Any:
    """The processes of an mpi4py communicator."""
    MPI = sys.modules.get("mpi4py.MPI")  # who has a communicator has loaded it
    if MPI is None or not isinstance(comm, MPI.Comm):
        raise TypeError(f"comm needs an mpi4py communicator, not {type(comm).__name__}")
    if comm == MPI.COMM_NULL or comm.Is_inter():
        raise InputError("comm is no communicator of one group of processes; hint: for instance MPI.COMM_WORLD")
    try:
        from . import _mpi
    except ImportError as error:
        raise ImportError(f"{_NO_MPI}: {error}") from error
    theirs, ours = MPI.Get_library_version(), _mpi.library()
    if not theirs.startswith(ours):
        raise InputError(
            f"mpi4py uses {theirs.splitlines()[0].split(',')[0]}, but ringsplat was built for {ours}; hint: "
            "build both for the same MPI (docs/python.md)"
        )
    return _mpi.connect(comm.py2f())


def _scalar_type(dtype: Any) -> str:
    kind = np.dtype(dtype)
    if kind == np.bool_:
        return "uint8"
    if not kind.isnative or kind.name not in TYPES:
        raise TypeError(
            f"a session's blocks cannot be {kind}; hint: use {', '.join(TYPES)} in native byte order, or bool"
        )
    return kind.name


def _layout_words(layout: Any) -> list[str]:
    if layout is None:
        return []
    if not isinstance(layout, dict):
        gps, renderers = layout
        layout = {"gps": gps, "renderers": renderers}
    words = []
    for name, value in layout.items():
        if name not in ("gps", "renderers", "bundle", "roles", "topology", "mesh", "routing"):
            raise TypeError(f"{name} is no part of a layout; hint: gps, renderers, bundle, roles, topology, mesh, routing")
        text = "x".join(map(str, value)) if isinstance(value, (tuple, list)) else str(value)
        words.append(f"--{name}={text}")
    return words


def _text(problem: Optional[Exception]) -> str:
    return "" if problem is None else str(problem) or type(problem).__name__


def _by_itself(method: F) -> F:
    """For calls that a rank makes by itself. What goes wrong there among several ranks is raised by the next collective
    call, on all, since the others would wait there for a rank that has ended."""

    @functools.wraps(method)
    def call(self: "Session", *args: Any, **options: Any) -> Any:
        with contextlib.nullcontext() if self.ranks == 1 else self._noted():
            return method(self, *args, **options)
        return len(self._blocks)

    return cast(F, call)


class Session(contextlib.AbstractContextManager["Session"]):
    """Renders a volume that lies in blocks, as often as wanted.

        session = ringsplat.Session(comm=MPI.COMM_WORLD)     # or Session(), for one process
        session.set_grid(shape=(256, 256, 256), dtype="float32")
        session.add_block((z, y, x), block)                  # where block[0, 0, 0] lies
        session.commit()
        image = session.render(tf="mr-soft", azimuth=30)     # on rank 0; None elsewhere

    comm : an mpi4py communicator, or None for this process alone
        All its ranks create the session and make the same collective calls in the same order. What one of several gets
        wrong, also in a call before that is its own, is raised by the next of them on all, and the session can be used on.
    layout : (gps, renderers) or dict(gps=, renderers=, bundle=, roles=, topology=, mesh=, routing=)
        Which ranks hold slices and which draw, as the program's options. Without it every rank does both.
    threads : int
        That share a rank's work.
    stall_timeout : float
        Seconds until a frame without progress fails, or a rank that the others wait for is named on stderr.
    visualisation_ranks : int
        The first so many ranks are set aside to draw and have no blocks; the others never wait for a picture.

    Blocks are kept until they are replaced. A picture has the same bits for any blocks, ranks and layout.
    """

    def __init__(
        self,
        comm: Any = None,
        layout: Any = None,
        threads: int = 1,
        stall_timeout: float = 60.0,
        visualisation_ranks: int = 0,
    ) -> None:
        words: list[str] = []
        self._problem: Optional[Exception] = None
        try:
            words = _layout_words(layout)
            threads, stall_timeout = operator.index(threads), float(stall_timeout)
            visualisation_ranks = operator.index(visualisation_ranks)
        except Exception as problem:
            self._problem, threads, stall_timeout, visualisation_ranks = problem, 1, 60.0, 0
        connected = None if comm is None else _connect(comm)
        self._cores: list[Any] = []
        with self._together():
            problem = _text(self._problem)
            self._cores.append(_core.BlockSession(connected, words, threads, stall_timeout, visualisation_ranks, problem))
        self._type: Optional[str] = None
        self._blocks: list[np.ndarray] = []
        # Before the interpreter ends, as MPI may be finalised when its last objects go.
        weakref.finalize(self, self._cores.clear)

    @property
    def rank(self) -> int:
        """This process's rank, from 0."""
        return self._open().rank

    @property
    def ranks(self) -> int:
        """How many processes share the volume."""
        return self._open().ranks

    @property
    def visualises(self) -> bool:
        """This rank is set aside to draw."""
        return self._open().visualises

    @_by_itself
    def set_grid(
        self,
        shape: Any = None,
        dtype: Any = "float32",
        *,
        dims: Any = None,
        spacing: Any = 1.0,
        origin: Any = (0, 0, 0),
        direction: Any = None,
        unit: str = "",
        quantity: str = "",
    ) -> None:
        """The whole volume: its `shape` (z, y, x) or `dims` (x, y, z) in voxels, and the blocks' type. `spacing`,
        `origin` and `direction` as for render(); `quantity` is what the values are, for annotations. Removes the blocks.
        """
        if (shape is None) == (dims is None):
            raise TypeError("give either shape=(z, y, x) or dims=(x, y, z)")
        sizes = [int(size) for size in (dims if dims is not None else tuple(shape)[::-1])]
        if len(sizes) != 3 or not all(0 < size < 2**31 for size in sizes):
            raise InputError(f"the grid has the dims {tuple(sizes)}; hint: three sizes from 1 to 2^31 - 1")
        scalar = _scalar_type(dtype)
        place = Volume("", unit=ascii_unit(unit), quantity=quantity)
        place.spacing, place.origin = three(spacing, "spacing"), three(origin, "origin")
        if direction is not None:
            place.direction = nine(direction)
        self._open().set_grid(place.grid(sizes, scalar))
        self._type = scalar
        self._blocks = []

    @_by_itself
    def add_block(self, start: Any, array: Any) -> int:
        """Adds one of this process's blocks, without ghosts: `array` [z, y, x] of any strides, of the grid's type, whose
        first voxel is the volume's [start], in the same order. Returns the block's number, from 0. The array is read by
        commit() and kept until then and beyond."""
        block = self._block(array)
        first = [int(one) for one in start]
        if len(first) != 3:
            raise TypeError(f"start needs (z, y, x), not {start!r}")
        end = [one + size for one, size in zip(first, block.shape)]
        number = self._open().add_block(first[::-1], end[::-1], address_of(block), strides_of(block))
        self._blocks.append(block)
        return number

    @_by_itself
    def update_block(self, number: int, array: Any) -> None:
        """The block's values of the next time step, for the next commit(): an array of the same shape. Not needed where
        the array that was added has been changed in place."""
        block = self._block(array)
        if not 0 <= number < len(self._blocks):
            raise InputError(f"there is no block {number}; hint: this rank has {len(self._blocks)}")
        if block.shape != self._blocks[number].shape:
            raise InputError(
                f"block {number} has the shape {self._blocks[number].shape}, not {block.shape}; hint: "
                "clear_blocks() and add others"
            )
        self._open().update_block(number, address_of(block), strides_of(block))
        self._blocks[number] = block

    def clear_blocks(self) -> None:
        """Removes this process's blocks."""
        self._open().clear_blocks()
        self._blocks = []

    def commit(self) -> None:
        """Reads all blocks, which must cover the grid exactly once, and hands their voxels to the ranks that draw them.
        Collective."""
        with self._together():
            self._open().commit()

    @property
    def range(self) -> tuple[float, float]:
        """The smallest and the largest finite value of the committed volume. Collective."""
        with self._together():
            low, high = self._open().range()
        return low, high

    def render(self, *, progress: bool = False, **options: "Unpack[PictureOptions]") -> "Image | list[Image] | None":
        """Renders the committed volume; collective, with rank 0's options. Returns the picture on rank 0, None elsewhere.

        With a list of angles (azimuth, elevation, roll, zoom) a list of pictures, which overlap on the ranks and are
        made faster than one by one.
        """
        core = self._open()
        words: list[str] = []
        views: Optional[list] = None
        with self._together(), contextlib.ExitStack() as stack:
            told = stack.enter_context(_progress.told(progress and core.rank == 0))
            if core.rank == 0:
                with self._noted():
                    words, views = stack.enter_context(command_line(options, session=True))
            pictures = core.render(words, views or [], told)
        if core.rank != 0:
            return None
        images = [Image(picture, None) for picture in pictures]
        return images if views is not None else images[0]

    def serve(
        self,
        *,
        name: str = "simulation",
        address: str = "127.0.0.1",
        port: int = 0,
        share: float = 0.05,
        allow_hosts: Sequence[str] = (),
        allow_origins: Sequence[str] = (),
        frame_origins: Sequence[str] = LOCAL_PAGES,
        **options: "Unpack[PictureOptions]",
    ) -> str:
        """Shows the volume in browsers from now on; collective, with the same arguments on all ranks. Returns the
        page's address on rank 0, an empty text elsewhere.

            print(session.serve(tf="mr-soft"))
            session.offer("viscosity", 0.1, 0, 1)
            for step in range(steps):
                solve(...)                           # in place, or session.update_block(0, block)
                viscosity = session.show(step, time)["viscosity"]

        The ranks draw between steps. Pictures may hold the simulation up for `share` of the time that it takes itself;
        a page may hold it, let it take single steps and change what is offered. `options` say what is seen first;
        sheets draw it. `address`, `port` and the allowed hosts, origins and frames are those of `ringsplat serve`.
        """
        with self._together(), contextlib.ExitStack() as stack:
            words: list[str] = []
            with self._noted():
                words, views = stack.enter_context(command_line(options, session=True))
                if views is not None:
                    raise TypeError("serve() takes one view, not lists of angles")
            lists = (list(allow_hosts), list(allow_origins), list(frame_origins))
            return cast(str, self._open().serve(words, name, address, port, share, *lists))

    @_by_itself
    def offer(
        self, name: str, value: float, low: float = 0.0, high: float = 1.0, *, choices: Optional[Sequence[str]] = None
    ) -> None:
        """Lets pages change a number between `low` and `high`, or choose one of `choices`, such as the field whose array
        update_block() is given; show() tells what it is, of choices the number, from 0. All ranks offer the same in the
        same order, after serve()."""
        words = None if choices is None else [str(one) for one in choices]
        self._open().offer(name, float(value), float(low), float(high), words)

    def act(self, file: "str | os.PathLike[str]", step: int) -> None:
        """Draws the pictures that a TOML file asks for after a step, of the blocks as they are now. The file is read at
        each step and may be changed while the program runs:

            [front]
            every = 10
            file = "front-{step}.png"
            azimuth = 30
            tf = "mr-soft"

        A section is a picture, its keys are `every`, `first` (a step), `file` and options of `ringsplat render`. What is
        wrong in it is warned of. Collective."""
        with self._together():
            self._open().act(os.fspath(file), step)

    def show(self, step: int, time: float = 0.0) -> dict[str, float]:
        """Shows the blocks as they are now, after a step. While nobody looks that costs next to nothing. While a page
        holds the simulation it returns only when the page lets it go on. Returns the numbers that are offered.
        Collective."""
        with self._together():
            return dict(self._open().show(step, time))

    def visualise(self) -> None:
        """On ranks that are set aside, after serve(): draws what pages want, until the others close() their sessions."""
        with self._together():
            self._open().visualise()

    def close(self) -> None:
        """Lets go of the volume and of the communicator's duplicate. Collective."""
        self._cores.clear()
        self._blocks = []

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _open(self) -> Any:
        if not self._cores:
            raise InputError("the session is closed; hint: make another")
        return self._cores[0]

    @contextlib.contextmanager
    def _noted(self) -> Iterator[None]:
        """What goes wrong is kept for the collective call to raise, as the other ranks must learn of it."""
        try:
            yield
        except Exception as problem:
            self._problem = self._problem or problem
            self._open().note_problem(_text(problem))

    @contextlib.contextmanager
    def _together(self) -> Iterator[None]:
        """Around a collective call: the rank that caused its error raises its own exception."""
        try:
            yield
        except InputError:
            if self._problem is not None:
                raise self._problem from None
            raise
        finally:
            self._problem = None

    def _block(self, array: Any) -> np.ndarray:
        if self._type is None:
            raise InputError("the session has no grid; hint: call set_grid() before add_block()")
        block = np.asarray(array)
        if block.ndim != 3:
            raise InputError(f"the block has the shape {block.shape}; hint: a block has the axes [z, y, x]")
        if _scalar_type(block.dtype) != self._type:
            raise TypeError(
                f"the block is {block.dtype}, but the grid is {self._type}; hint: convert it with "
                f".astype('{self._type}'), or give set_grid() another dtype"
            )
        return block.view(np.uint8) if block.dtype == np.bool_ else block


document(Session.render, session=True)
document(Session.serve, session=True)
