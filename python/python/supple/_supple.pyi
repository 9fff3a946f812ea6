"""Types of the compiled part. SI units: m, kg, s, N, J, rad. V vertices, F triangles, B bones, J joints of a pose."""

from os import PathLike
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

__version__: str
BAKE_PHASES: List[str]

Path = Union[str, PathLike[str]]
Recipe = Union[Path, Mapping[str, Any]]
Progress = Callable[[int, int, str], Any]
PoseOffsets = Callable[[npt.NDArray[np.float64]], npt.ArrayLike]
Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

class Avatar:
    """A baked avatar, which does not change."""

    @staticmethod
    def load(
        path: Path,
        betas: Optional[npt.ArrayLike] = None,
        *,
        betas_of: Optional[Path] = None,
        recipe: Optional[Recipe] = None,
        scale: Optional[float] = None,
        up: Optional[str] = None,
        progress: Optional[Progress] = None,
    ) -> Avatar: ...
    @staticmethod
    def sample(
        name: str = "hand",
        betas: Optional[npt.ArrayLike] = None,
        *,
        recipe: Optional[Mapping[str, Any]] = None,
        progress: Optional[Progress] = None,
    ) -> Avatar: ...
    @staticmethod
    def from_arrays(
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        joints: Optional[npt.ArrayLike],
        parents: npt.ArrayLike,
        weights: npt.ArrayLike,
        *,
        names: Optional[Sequence[str]] = None,
        shape_directions: Optional[npt.ArrayLike] = None,
        joint_directions: Optional[npt.ArrayLike] = None,
        joint_regressor: Optional[Any] = None,
        weight_bones: Optional[npt.ArrayLike] = None,
        pose_offsets: Union[npt.ArrayLike, PoseOffsets, None] = None,
        betas: Optional[npt.ArrayLike] = None,
        tissue: Sequence[str] = ...,
        rigid: Sequence[str] = ...,
        up: str = "y",
        name: str = "avatar",
        recipe: Optional[Mapping[str, Any]] = None,
        progress: Optional[Progress] = None,
    ) -> Avatar: ...
    def save(self, path: Path, *, layer: bool = True) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def up(self) -> str: ...
    @property
    def skin(self) -> Floats: ...
    @property
    def faces(self) -> Indices: ...
    @property
    def areas(self) -> Floats: ...
    @property
    def joints(self) -> Floats: ...
    @property
    def parents(self) -> Indices: ...
    @property
    def bone_names(self) -> List[str]: ...
    @property
    def pose_names(self) -> List[str]: ...
    @property
    def weights(self) -> Floats: ...
    @property
    def handles(self) -> Floats: ...
    @property
    def cubature_points(self) -> Floats: ...
    @property
    def cubature_weights(self) -> Floats: ...
    @property
    def file_vertices(self) -> Optional[Indices]: ...
    @property
    def dofs(self) -> int: ...
    @property
    def tissue_mass(self) -> float: ...
    @property
    def notes(self) -> List[str]: ...
    @property
    def report(self) -> Optional[Dict[str, Any]]: ...

class Simulation:
    """An avatar in time."""

    def __init__(
        self, avatar: Avatar, backend: str = "auto", *, up: Optional[str] = None, **settings: Any
    ) -> None: ...
    def follow(
        self,
        poses: Union[npt.ArrayLike, Path],
        trans: Optional[npt.ArrayLike] = None,
        *,
        fps: Optional[float] = None,
        options: Optional[Mapping[str, Any]] = None,
    ) -> Simulation: ...
    def track(
        self,
        poses: Union[npt.ArrayLike, Path],
        trans: Optional[npt.ArrayLike] = None,
        *,
        fps: Optional[float] = None,
        options: Optional[Mapping[str, Any]] = None,
        rotation: Optional[Tuple[float, float]] = None,
        position: Optional[Tuple[float, float]] = None,
    ) -> Simulation: ...
    def follow_matrices(self, matrices: npt.ArrayLike) -> Simulation: ...
    def hold(self) -> Simulation: ...
    def ragdoll(self, bending_stiffness: float = 10.0) -> Simulation: ...
    def reset(self) -> Simulation: ...
    def settle(self) -> float: ...
    def step(self, dt: float = ...) -> StepResult: ...
    def simulate(
        self,
        poses: Union[npt.ArrayLike, Path, None] = None,
        trans: Optional[npt.ArrayLike] = None,
        fps: Optional[float] = None,
        *,
        options: Optional[Mapping[str, Any]] = None,
        duration: Optional[float] = None,
        record: Optional[Sequence[str]] = None,
        substeps: int = 1,
        progress: Optional[Callable[[int, int], Any]] = None,
    ) -> Clip: ...
    def state(self) -> StepResult: ...
    def potential(self, dt: float = ...) -> Potential: ...
    def configure(self, **settings: Any) -> Simulation: ...
    @property
    def settings(self) -> Dict[str, Any]: ...
    @property
    def avatar(self) -> Avatar: ...
    @property
    def backend(self) -> str: ...
    @property
    def time(self) -> float: ...
    @property
    def up(self) -> str: ...
    @property
    def motion_notes(self) -> List[str]: ...
    def add_sphere(
        self,
        radius: float,
        position: npt.ArrayLike,
        *,
        friction: float = 0.0,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...
    def add_capsule(
        self,
        start: npt.ArrayLike,
        end: npt.ArrayLike,
        radius: float,
        *,
        friction: float = 0.0,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...
    def add_cylinder(
        self,
        start: npt.ArrayLike,
        end: npt.ArrayLike,
        radius: float,
        *,
        friction: float = 0.0,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...
    def add_box(
        self,
        size: npt.ArrayLike,
        position: npt.ArrayLike,
        rotation: Optional[npt.ArrayLike] = None,
        *,
        friction: float = 0.0,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...
    def add_half_space(
        self,
        point: npt.ArrayLike,
        normal: npt.ArrayLike,
        *,
        friction: float = 0.0,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...
    def add_ground(
        self,
        height: float = 0.0,
        *,
        friction: float = 0.5,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...
    def add_mesh(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        position: Optional[npt.ArrayLike] = None,
        rotation: Optional[npt.ArrayLike] = None,
        *,
        friction: float = 0.0,
        stiffness: Optional[float] = None,
        margin: float = 0.0,
    ) -> Collider: ...

class Collider:
    """A collider of a simulation, to be moved between steps."""

    def move_to(
        self, position: Optional[npt.ArrayLike] = None, rotation: Optional[npt.ArrayLike] = None
    ) -> None: ...
    def place_at(
        self, position: Optional[npt.ArrayLike] = None, rotation: Optional[npt.ArrayLike] = None
    ) -> None: ...
    def remove(self) -> None: ...
    @property
    def position(self) -> Floats: ...
    @property
    def rotation(self) -> Floats: ...
    @property
    def friction(self) -> float: ...

class StepResult:
    """A step's result; it stays as it is when the simulation goes on."""

    @property
    def time(self) -> float: ...
    @property
    def vertices(self) -> Floats: ...
    @property
    def normals(self) -> Floats: ...
    @property
    def displacements(self) -> Floats: ...
    @property
    def contact_forces(self) -> Floats: ...
    @property
    def pressures(self) -> Floats: ...
    @property
    def contact_force(self) -> Floats: ...
    @property
    def positions(self) -> Floats: ...
    @property
    def rotations(self) -> Floats: ...
    @property
    def handles(self) -> Floats: ...
    @property
    def loads(self) -> Floats: ...
    @property
    def energies(self) -> Dict[str, float]: ...
    @property
    def report(self) -> Dict[str, Any]: ...

class Clip:
    """A whole clip as stacked arrays: T frames, the start among them."""

    @property
    def time(self) -> Floats: ...
    @property
    def vertices(self) -> Optional[Floats]: ...
    @property
    def displacements(self) -> Optional[Floats]: ...
    @property
    def contact_forces(self) -> Optional[Floats]: ...
    @property
    def positions(self) -> Floats: ...
    @property
    def rotations(self) -> Floats: ...
    @property
    def loads(self) -> Floats: ...
    @property
    def energies(self) -> Dict[str, Floats]: ...
    @property
    def faces(self) -> Indices: ...
    @property
    def bone_names(self) -> List[str]: ...
    def save(self, path: Path) -> None: ...
    def __len__(self) -> int: ...

class Potential:
    """E(q) of the step that comes next, at a state q; n degrees of freedom."""

    @property
    def dofs(self) -> int: ...
    @property
    def fixed(self) -> npt.NDArray[np.bool_]: ...
    @property
    def positions(self) -> Floats: ...
    @property
    def handles(self) -> Floats: ...
    def moved(self, delta: npt.ArrayLike) -> Potential: ...
    def at_state_of(self, simulation: Simulation) -> Potential: ...
    def energy(self) -> float: ...
    def energies(self) -> Dict[str, float]: ...
    def gradient(self) -> Floats: ...
    def hessian(self, form: str = "solver", *, dense: bool = False) -> Any: ...
