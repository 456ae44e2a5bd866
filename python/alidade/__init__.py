# SPDX-License-Identifier: MIT
from ._alidade import (Cloud, Error, Index, __version__, compare, open, render, viewshed, visible)
