# SPDX-License-Identifier: MIT
def classFactory(interface):
    """What QGIS calls when it loads the plugin."""
    from .provider import Plugin
    return Plugin()
