
# Made by tests/python/stubs.py from here
def sql_shard_plan(files: _Files, *, classes: _List | None = None, ignore_classes: _List | None = None,
                   where: str | None = None, crop: _File | Sequence[float] | None = None, crop_crs: str | None = None,
                   columns: _List | None = None, crs: str | None = None, reproject: str | None = None,
                   vertical_unit: Literal["m", "ft", "us-ft"] | None = None, cache: _File | None = None,
                   allow_host: str | Sequence[str] | None = None, cache_size: int | str | None = None, yes: bool = False,
                   output: _File | None = None, shard: str | Sequence[str] | None = None, table: str | None = None,
                   memory: int | str | None = None, color_depth: float | str | None = None, partial: bool = False,
                   workers: int = -1, progress: Callable[[int, int], Any] | None = None,
                   note: Callable[[str], Any] | None = None) -> dict[str, Any]: ...
# to here
