# SPDX-License-Identifier: MIT
from qgis.core import QgsApplication, QgsProcessingProvider

from .algorithm import CommandAlgorithm
from .commands import COMMANDS


class Provider(QgsProcessingProvider):
    def loadAlgorithms(self):
        for command in COMMANDS:
            self.addAlgorithm(CommandAlgorithm(command))

    def id(self):
        return "alidade"

    def name(self):
        return "Alidade"

    def longName(self):
        return "Alidade: ray queries and pictures of point clouds"


class Plugin:
    def __init__(self):
        self.provider = None

    def initProcessing(self):
        self.provider = Provider()
        QgsApplication.processingRegistry().addProvider(self.provider)

    def initGui(self):
        self.initProcessing()

    def unload(self):
        QgsApplication.processingRegistry().removeProvider(self.provider)
