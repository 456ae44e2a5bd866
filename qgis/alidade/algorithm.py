# SPDX-License-Identifier: MIT
import json
import os
import re
import signal
import subprocess
import tempfile
import threading

from qgis.core import (QgsCoordinateReferenceSystem, QgsCoordinateTransform, QgsProcessing, QgsProcessingAlgorithm,
                       QgsProcessingException, QgsProcessingParameterBoolean, QgsProcessingParameterDefinition,
                       QgsProcessingParameterEnum, QgsProcessingParameterExtent, QgsProcessingParameterFile,
                       QgsProcessingParameterFileDestination, QgsProcessingParameterNumber,
                       QgsProcessingParameterRasterDestination, QgsProcessingParameterString,
                       QgsProcessingParameterVectorLayer)

FILTERS = {"cloud": "LAZ (*.laz);;LAS (*.las);;PLY (*.ply)", "picture": "PNG (*.png);;JPEG (*.jpg);;EXR (*.exr)",
           "table": "CSV (*.csv)"}


def program():
    """The program: of the variable ALIDADE_PROGRAM, else on the PATH."""
    return os.environ.get("ALIDADE_PROGRAM", "alidade")


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
        if parameter.kind == "flag":
            return QgsProcessingParameterBoolean(name, label, bool(default))
        if parameter.kind == "text":
            return QgsProcessingParameterString(name, label, default, optional=default is None)
        if parameter.kind in ("points", "line"):
            kind = QgsProcessing.TypeVectorPoint if parameter.kind == "points" else QgsProcessing.TypeVectorLine
            return QgsProcessingParameterVectorLayer(name, label, [kind])
        if parameter.kind == "extent":
            return QgsProcessingParameterExtent(name, label, optional=True)
        if parameter.kind == "raster":
            return QgsProcessingParameterRasterDestination(name, label)
        return QgsProcessingParameterFileDestination(name, label, FILTERS[parameter.kind])

    @staticmethod
    def cloud_system(cloud):
        """The reference system of the cloud, by 'alidade info'; not valid if it states none."""
        described = subprocess.run([program(), "info", cloud, "--json"], capture_output=True, text=True)
        text = (json.loads(described.stdout).get("crs") or "") if described.returncode == 0 else ""
        system = QgsCoordinateReferenceSystem.fromWkt(text)
        return system if system.isValid() else QgsCoordinateReferenceSystem(text)

    def corridor(self, layer, width, cloud, context, folder):
        """What lies within `width` of the lines of a layer, as a file of polygons in the system of the cloud."""
        system = self.cloud_system(cloud)
        areas = []
        for feature in layer.getFeatures():
            geometry = feature.geometry()
            if system.isValid() and layer.crs().isValid():
                geometry.transform(QgsCoordinateTransform(layer.crs(), system, context.transformContext()))
            area = json.loads(geometry.buffer(width, 16).asJson(17))
            areas.append({"type": "Feature", "properties": {}, "geometry": area})
        if not areas:
            raise QgsProcessingException("the layer has no line; expected one at least")
        path = os.path.join(folder, "corridor.geojson")
        with open(path, "w") as file:
            json.dump({"type": "FeatureCollection", "features": areas}, file)
        return path

    def value(self, parameter, parameters, context, feedback, cloud, folder):
        """The word behind the option, or None."""
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
            return self.corridor(self.parameterAsVectorLayer(parameters, name, context), width, cloud, context, folder)
        if parameter.kind == "extent":
            if not parameters.get(name):
                return None
            box = self.parameterAsExtent(parameters, name, context, self.cloud_system(cloud))
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
            words += self.parameterAsString(parameters, "EXTRA", context).split()
            self.run_program(words, feedback)
        return results

    @staticmethod
    def run_program(words, feedback):
        feedback.pushCommandInfo(" ".join(words))
        try:
            process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        except FileNotFoundError:
            raise QgsProcessingException(
                f"the program {words[0]} was not found; expected it on the PATH, or its file in the variable "
                "ALIDADE_PROGRAM") from None
        finished = threading.Event()

        def watch():
            while not finished.wait(0.2):
                if feedback.isCanceled():
                    process.send_signal(signal.SIGINT)

        watcher = threading.Thread(target=watch)
        watcher.start()
        last = ""
        try:
            for line in process.stderr:
                share = re.search(r"(\d+) %", line)
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
