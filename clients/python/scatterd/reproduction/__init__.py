"""All tables and figures of two papers on particle methods, made by a running service.

    from scatterd import Client
    from scatterd.reproduction import reproduce

    reproduce(Client(), "reproduction")
"""

from .parts import Ask, Item, Table
from .run import ITEMS, Bar, reproduce, sampled

__all__ = ["ITEMS", "Ask", "Bar", "Item", "Table", "reproduce", "sampled"]
