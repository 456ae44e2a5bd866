
from ._answers import Change

# Made by tests/python/stubs.py from here
def change(before: _File, after: _File, *, classes: _List | None = None, where: str | None = None,
           crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
           crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
           cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
           yes: bool = False, output: _File | None = None, origin_before: str | ArrayLike | None = None,
           origins_before: _File | None = None, origin_after: str | ArrayLike | None = None,
           origins_after: _File | None = None, no_sight: bool = False, max_range: float | None = None,
           registration_error: float | None = None, normal_radius: float | None = None,
           cylinder_radius: float | None = None, max_distance: float | None = None, ignore_classes: _List | None = None,
           overwrite: bool = False, memory: int | str | None = None, partial: bool = False, workers: int = -1,
           progress: Callable[[int, int], Any] | None = None, note: Callable[[str], Any] | None = None) -> Change: ...
# to here
