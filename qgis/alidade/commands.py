# SPDX-License-Identifier: MIT
"""The commands of the program in QGIS: one entry for each algorithm of the Processing toolbox."""
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Parameter:
    """A parameter of an algorithm and the option that it becomes.

    kind: number, choice, text, points (a layer of points), line (a layer of one line), extent,
    raster, cloud, picture, table (outputs). `option` empty: not passed to the
    program, used with another parameter. `default` None: optional, the program decides.
    """
    name: str
    label: str
    kind: str
    option: str
    default: object = None
    choices: tuple = ()
    help: str = ""


@dataclass(frozen=True)
class Command:
    name: str
    label: str
    group: str
    words: tuple
    help: str
    parameters: tuple
    fixed: tuple = field(default=())


OBSERVERS = Parameter("OBSERVERS", "Observers", "points", "--observers",
                      help="Layer of points in any reference system. Fields name, height, azimuth_min, azimuth_max, "
                           "elevation_min, elevation_max and max_distance count for each observer.")
HEIGHT = Parameter("OBSERVER_HEIGHT", "Height of the eye above the ground", "number", "--observer-height",
                   help="Empty: 2 above the ground, or the z of the points.")
RESOLUTION = Parameter("RESOLUTION", "Cell size", "number", "--resolution",
                       help="In the unit of the cloud. Empty: at most 1000 cells along a side.")
EXTENT = Parameter("EXTENT", "Extent", "extent", "--extent", help="Empty: the whole cloud.")
COLOR = Parameter("COLOR", "Colour by", "choice", "--color-by", 0,
                  ("automatic", "rgb", "height", "classification", "intensity", "normal", "return_number"))

COMMANDS = (
    Command("overview", "Overview picture", "Pictures", ("render",),
            "Draws the whole cloud from the south-west, lit by sun and sky.",
            (COLOR,
             Parameter("SAMPLES", "Samples per pixel", "number", "--samples", 16.0,
                       help="Noise halves with four times as many."),
             Parameter("SIZE", "Width and height (pixels)", "text", "--size", "1200x800"),
             Parameter("OUTPUT", "Picture", "picture", "-o"))),
    Command("orthophoto", "Orthophoto", "Pictures", ("render",),
            "Draws the cloud from straight above as a cloud-optimised GeoTIFF.",
            (COLOR, Parameter("RESOLUTION", "Size of a pixel", "number", "--resolution", 0.5), EXTENT,
             Parameter("MODE", "Light", "choice", "--mode", 0, ("path", "ambient_occlusion", "flat")),
             Parameter("SAMPLES", "Samples per pixel", "number", "--samples", 16.0),
             Parameter("OUTPUT", "Orthophoto", "raster", "-o")),
            ("--orthographic", "top")),
    Command("ground_layers", "Surface model, intensity, classes or density", "Pictures", ("render",),
            "Rasters of what is seen from straight above: elevation is a surface model.",
            (Parameter("LAYER", "Layer", "choice", "--layers", 0,
                       ("elevation", "intensity", "classification", "density", "count")),
             Parameter("RESOLUTION", "Size of a pixel", "number", "--resolution", 0.5), EXTENT,
             Parameter("OUTPUT", "Raster", "raster", "-o")),
            ("--orthographic", "top")),
    Command("viewshed", "Viewshed", "Visibility", ("visibility", "raster"),
            "Where the ground is seen from observers: sight lines pass through the points themselves, below crowns and "
            "bridges.",
            (OBSERVERS, HEIGHT, RESOLUTION, EXTENT,
             Parameter("MODE", "Values", "choice", "--mode", 0, ("visible", "count", "height", "fraction"),
                       help="1 or 0; number of observers; lowest visible height; share of free lines."),
             Parameter("TARGET_HEIGHT", "Height of what is looked at", "number", "--target-height", 0.0),
             Parameter("MAX_DISTANCE", "Largest distance", "number", "--max-distance"),
             Parameter("OUTPUT", "Viewshed", "raster", "-o"))),
    Command("visible_points", "Visibility of points", "Visibility", ("visibility", "points"),
            "Writes the cloud with the attributes Visible, VisibleCount and VisibleBy.",
            (OBSERVERS, HEIGHT, Parameter("MAX_DISTANCE", "Largest distance", "number", "--max-distance"),
             Parameter("TRANSPARENCY", "Surfaces that block", "number", "--transparency", 1.0),
             Parameter("OUTPUT", "Cloud", "cloud", "-o"))),
    Command("horizon", "Horizon", "Visibility", ("visibility", "horizon"),
            "Elevation of the horizon by azimuth at one observer, as a table.",
            (OBSERVERS, HEIGHT, Parameter("OUTPUT", "Table", "table", "-o"))),
    Command("sun_hours", "Hours of sun", "Visibility", ("visibility", "sun"),
            "Hours of direct sun on the ground, summed from the first day to the last, with the shadows of everything scanned.",
            (Parameter("FROM", "First day (YYYY-MM-DD)", "text", "--from", "2026-06-21"),
             Parameter("TO", "Last day", "text", "--to", help="Empty: the first day alone."), RESOLUTION, EXTENT,
             Parameter("OUTPUT", "Hours", "raster", "-o"))),
    Command("profile", "Points along a line", "Clouds", ("convert",),
            "Writes the points within a distance of the lines of a layer, at any height, for cross-sections and corridors.",
            (Parameter("LINE", "Line", "line", "--crop"), Parameter("WIDTH", "Distance from the line", "number", "", 1.0),
             Parameter("OUTPUT", "Cloud", "cloud", "-o")),
            ("--crop-crs", "cloud")),
    Command("convert", "Convert, select and thin", "Clouds", ("convert",),
            "Writes clouds of any format as LAS, LAZ or PLY.",
            (Parameter("CLASSES", "Classes", "text", "--classes", help="Such as 2,6. Empty: all."),
             Parameter("WHERE", "Condition", "text", "--where",
                       help='Such as "classification = 2 AND intensity > 100".'),
             Parameter("SPACING", "Spacing", "number", "--spacing", help="Thins to one point in a cube of this side."),
             Parameter("REPROJECT", "Reference system", "text", "--reproject", help="Such as EPSG:25832."),
             Parameter("OUTPUT", "Cloud", "cloud", "-o"))),
)
