
from .jobs import change as change
