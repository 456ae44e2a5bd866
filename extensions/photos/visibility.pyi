
# Made by tests/python/stubs.py from here
def photos(files: _Files, *, classes: _List | None = None, where: str | None = None,
           crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
           crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
           cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
           yes: bool = False, camera: _File | None = None, camera_name: str | Sequence[str] | None = None,
           lens: _File | None = None, original_world: bool = False, photos: _File | None = None,
           max_distance: float | None = None, occluder: Literal["auto", "disc", "sphere"] | None = None,
           radius: float | None = None, radius_max: float | None = None, transparency: int | None = None,
           mesh: _Files | None = None, terrain: _File | None = None, ignore_classes: _List | None = None,
           output: _File | None = None, colorize: bool = False, footprints: _File | None = None,
           footprint_cell: float | None = None, overwrite: bool = False, checkpoint: _File | None = None,
           checkpoint_interval: float | None = None, resume: bool = False, memory: int | str | None = None,
           partial: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
           note: Callable[[str], Any] | None = None) -> Points: ...
# to here
