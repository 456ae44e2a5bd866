
# Made by tests/python/stubs.py from here
def place(files: _Files, *, classes: _List | None = None, where: str | None = None,
          crop: _File | Sequence[float] | None = None, crop_crs: str | None = None, columns: _List | None = None,
          crs: str | None = None, reproject: str | None = None, vertical_unit: Literal["m", "ft", "us-ft"] | None = None,
          cache: _File | None = None, allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None,
          yes: bool = False, observer: str | ArrayLike | None = None, observers: _File | None = None,
          observers_crs: str | None = None, anywhere: bool = False, observer_grid: float | None = None,
          observer_height: float | None = None, max_distance: float | None = None,
          horizontal_fov: str | ArrayLike | None = None, direction_range: str | ArrayLike | None = None,
          vertical_fov: str | ArrayLike | None = None, target_spacing: float | None = None,
          target_height: float | None = None, target_classes: _List | None = None, class_weights: _List | None = None,
          occluder: Literal["auto", "disc", "sphere"] | None = None, radius: float | None = None,
          radius_max: float | None = None, transparency: int | None = None, mesh: _Files | None = None,
          terrain: _File | None = None, ignore_classes: _List | None = None, count: int | None = None,
          output: _File | None = None, curve: _File | None = None, overwrite: bool = False, checkpoint: _File | None = None,
          checkpoint_interval: float | None = None, resume: bool = False, memory: int | str | None = None,
          partial: bool = False, workers: int = -1, progress: Callable[[int, int], Any] | None = None,
          note: Callable[[str], Any] | None = None) -> Rows: ...
# to here
