# SPDX-License-Identifier: MIT
import json
import os
import re
import shlex
import signal
import subprocess
import tempfile
import threading

from qgis.core import (QgsCoordinateReferenceSystem, QgsCoordinateTransform, QgsProcessing, QgsProcessingAlgorithm,
                       QgsProcessingException, QgsProcessingParameterDefinition,
                       QgsProcessingParameterEnum, QgsProcessingParameterExtent, QgsProcessingParameterFeatureSource,
                       QgsProcessingParameterFile,
                       QgsProcessingParameterFileDestination, QgsProcessingParameterNumber,
                       QgsProcessingParameterRasterDestination, QgsProcessingParameterString)

FILTERS = {"cloud": "LAZ (*.laz);;LAS (*.las);;PLY (*.ply)", "picture": "PNG (*.png);;JPEG (*.jpg);;EXR (*.exr)",
           "table": "CSV (*.csv)"}


def program():
    """The program: of the variable ALIDADE_PROGRAM, else on the PATH."""
    return os.environ.get("ALIDADE_PROGRAM", "alidade")


def start(words, **pipes):
    """Starts the program; its stderr, and its stdout unless redirected, are text."""
    try:
        return subprocess.Popen(words, stderr=subprocess.PIPE, text=True, errors="replace", **pipes)
    except FileNotFoundError:
        raise QgsProcessingException(
            f"the program {words[0]} was not found; expected it on the PATH, or its file in the variable "
            "ALIDADE_PROGRAM") from None


def run(words):
    """Runs the program to its end."""
    process = start(words, stdout=subprocess.PIPE)
    out, errors = process.communicate()
    return subprocess.CompletedProcess(words, process.returncode, out, errors)


class CommandAlgorithm(QgsProcessingAlgorithm):
    """An entry of commands.py."""

    def __init__(self, command):
        super().__init__()
        self.command = command

    def createInstance(self):
        return CommandAlgorithm(self.command)

    def name(self):
        return self.command.name

    def displayName(self):
        return self.command.label

    def group(self):
        return self.command.group

    def groupId(self):
        return self.command.group.lower()

    def shortHelpString(self):
        lines = [self.command.help, ""]
        lines += [f"{parameter.label}: {parameter.help}" for parameter in self.command.parameters if parameter.help]
        return "\n".join(lines + ["", f"Runs 'alidade {' '.join(self.command.words)}'."])

    def initAlgorithm(self, configuration=None):
        self.addParameter(QgsProcessingParameterFile("CLOUD", "Point cloud (LAS, LAZ, COPC, PLY, E57, .alidade, ...)"))
        for parameter in self.command.parameters:
            self.addParameter(self.definition(parameter))
        extra = QgsProcessingParameterString("EXTRA", "Further options of the program", optional=True)
        extra.setFlags(extra.flags() | QgsProcessingParameterDefinition.FlagAdvanced)
        self.addParameter(extra)

    @staticmethod
    def definition(parameter):
        name, label, default = parameter.name, parameter.label, parameter.default
        if parameter.kind == "number":
            return QgsProcessingParameterNumber(name, label, QgsProcessingParameterNumber.Double, default, default is None)
        if parameter.kind == "choice":
            return QgsProcessingParameterEnum(name, label, list(parameter.choices), defaultValue=default)
        if parameter.kind == "text":
            return QgsProcessingParameterString(name, label, default, optional=default is None)
        if parameter.kind in ("points", "line"):
            kind = QgsProcessing.TypeVectorPoint if parameter.kind == "points" else QgsProcessing.TypeVectorLine
            return QgsProcessingParameterFeatureSource(name, label, [kind])
        if parameter.kind == "extent":
            return QgsProcessingParameterExtent(name, label, optional=True)
        if parameter.kind == "raster":
            return QgsProcessingParameterRasterDestination(name, label)
        return QgsProcessingParameterFileDestination(name, label, FILTERS[parameter.kind])

    @staticmethod
    def cloud_system(cloud):
        """The reference system of the cloud, by 'alidade info'."""
        described = run([program(), "info", cloud, "--json"])
        if described.returncode != 0:
            raise QgsProcessingException(described.stderr.strip())
        facts = json.loads(described.stdout)
        codes = [code for code in facts.get("epsg") or [] if not code.startswith("vertical")]
        system = QgsCoordinateReferenceSystem.fromWkt(facts.get("crs") or "")
        return system if system.isValid() or not codes else QgsCoordinateReferenceSystem(codes[0])

    def to_cloud(self, system, cloud, context):
        """The transform from a layer's system to that of the cloud; None if the layer states none."""
        if not system.isValid():
            return None
        of_cloud = self.cloud_system(cloud)
        if not of_cloud.isValid():
            raise QgsProcessingException(f"the reference system of {cloud} is unknown; expected one that the file states, or "
                                         "a layer without a system")
        return QgsCoordinateTransform(system, of_cloud, context.transformContext())

    def corridor(self, source, width, cloud, context, folder):
        """A file of polygons within `width` of the lines of a layer, in the system of the cloud."""
        transform = self.to_cloud(source.sourceCrs(), cloud, context)
        areas = []
        for feature in source.getFeatures():
            geometry = feature.geometry()
            if transform:
                geometry.transform(transform)
            area = json.loads(geometry.buffer(width, 16).asJson(17))
            areas.append({"type": "Feature", "properties": {}, "geometry": area})
        if not areas:
            raise QgsProcessingException("the layer has no line; expected one at least")
        path = os.path.join(folder, "corridor.geojson")
        with open(path, "w") as file:
            json.dump({"type": "FeatureCollection", "features": areas}, file)
        return path

    def value(self, parameter, parameters, context, feedback, cloud, folder):
        """The value of the option as a word, or None."""
        name = parameter.name
        if parameter.kind == "number":
            value = parameters.get(name, parameter.default)
            if value is None:
                return None
            number = self.parameterAsDouble(parameters, name, context)
            return str(int(number)) if number == int(number) else repr(number)
        if parameter.kind == "choice":
            return parameter.choices[self.parameterAsEnum(parameters, name, context)]
        if parameter.kind == "text":
            return self.parameterAsString(parameters, name, context) or None
        if parameter.kind == "points":
            return self.parameterAsCompatibleSourceLayerPath(parameters, name, context, ["gpkg", "geojson", "shp"], "gpkg",
                                                             feedback)
        if parameter.kind == "line":
            width = self.parameterAsDouble(parameters, "WIDTH", context)
            return self.corridor(self.parameterAsSource(parameters, name, context), width, cloud, context, folder)
        if parameter.kind == "extent":
            if not parameters.get(name):
                return None
            system = self.parameterAsExtentCrs(parameters, name, context)
            transform = self.to_cloud(system, cloud, context)
            box = self.parameterAsExtent(parameters, name, context, transform.destinationCrs() if transform else system)
            return f"{box.xMinimum()!r},{box.yMinimum()!r},{box.xMaximum()!r},{box.yMaximum()!r}"
        return self.parameterAsOutputLayer(parameters, name, context) if parameter.kind == "raster" else \
            self.parameterAsFileOutput(parameters, name, context)

    def processAlgorithm(self, parameters, context, feedback):
        cloud = self.parameterAsFile(parameters, "CLOUD", context)
        results = {}
        with tempfile.TemporaryDirectory() as folder:
            words = [program(), *self.command.words, cloud, *self.command.fixed, "--overwrite"]
            for parameter in self.command.parameters:
                value = self.value(parameter, parameters, context, feedback, cloud, folder)
                if value is None or not parameter.option:
                    continue
                words += [parameter.option, value]
                if parameter.kind in ("raster", "cloud", "picture", "table"):
                    results[parameter.name] = value
            words += shlex.split(self.parameterAsString(parameters, "EXTRA", context))
            self.run_program(words, feedback)
        return results

    @staticmethod
    def run_program(words, feedback):
        feedback.pushCommandInfo(shlex.join(words))
        process = start(words, stdout=subprocess.DEVNULL)
        finished = threading.Event()

        def watch():
            while not finished.wait(0.2):
                if feedback.isCanceled():
                    # Once: the program then cleans up; a second time would end it at once.
                    process.send_signal(signal.SIGINT)
                    return

        watcher = threading.Thread(target=watch)
        watcher.start()
        last = ""
        try:
            for line in process.stderr:
                share = re.match(r"[^:]+:\s+(\d+) %", line)
                if share:
                    feedback.setProgress(int(share[1]))
                elif line.strip():
                    feedback.pushInfo(line.strip())
                    last = line.strip()
        finally:
            code = process.wait()
            finished.set()
            watcher.join()
        if code != 0 and not feedback.isCanceled():
            raise QgsProcessingException(last or f"alidade ended with {code}")
