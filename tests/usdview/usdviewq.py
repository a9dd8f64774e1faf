"""A strict stand-in for pxr.Usdviewq, which no wheel has: what usdview 24.08 documents for plugins, and nothing more.

A name that is not documented is an AttributeError, an argument that does not fit a TypeError.
"""

import importlib
import sys
import types
from contextlib import contextmanager

from pxr import Sdf, Tf, Usd

__all__ = ["Answers", "PluginRegistry", "PluginUIBuilder", "UsdviewApi", "installed"]


class PluginContainer:
    """Base of plugins' containers."""

    def deferredImport(self, moduleName):
        return DeferredImport(moduleName, self.__module__)

    def registerPlugins(self, plugRegistry, plugCtx):
        raise TypeError("a container must register its plugins")

    def configureView(self, plugRegistry, plugUIBuilder):
        raise TypeError("a container must configure the view")


class DeferredImport:
    """Gives functions that import the module when they are called."""

    def __init__(self, moduleName, packageName):
        self._names = moduleName, packageName

    def __getattr__(self, name):
        def function(*arguments):
            return getattr(importlib.import_module(self._names[0], package=self._names[1]), name)(*arguments)

        return function


class CommandPlugin:
    def __init__(self, name, displayName, callback, description, usdviewApi):
        self.name, self.displayName, self.description = name, displayName, description
        self._callback, self._api = callback, usdviewApi

    def run(self):
        self._callback(self._api)


class PluginRegistry:
    def __init__(self, usdviewApi):
        self._api, self.commands = usdviewApi, {}

    def registerCommandPlugin(self, name, displayName, callback, description=""):
        assert name not in self.commands, f"{name} is registered twice"
        assert callable(callback)
        self.commands[name] = CommandPlugin(name, displayName, callback, description, self._api)
        return self.commands[name]

    def getCommandPlugin(self, name):
        return self.commands.get(name)


class PluginMenu:
    def __init__(self):
        self.items, self.submenus = [], {}

    def addItem(self, commandPlugin, shortcut=None):
        assert isinstance(commandPlugin, CommandPlugin)
        self.items.append(commandPlugin)

    def findOrCreateSubmenu(self, menuName):
        return self.submenus.setdefault(menuName, PluginMenu())

    def addSeparator(self):
        self.items.append(None)


class PluginUIBuilder:
    def __init__(self):
        self.menus = {}

    def findOrCreateMenu(self, menuName):
        return self.menus.setdefault(menuName, PluginMenu())


class ViewSettings:
    __slots__ = ("displayGuide",)

    def __init__(self):
        self.displayGuide = False


class DataModel:
    __slots__ = ("_frame", "viewSettings")

    def __init__(self, frame):
        self._frame, self.viewSettings = frame, ViewSettings()

    @property
    def currentFrame(self):
        return self._frame

    @currentFrame.setter
    def currentFrame(self, value):
        if not isinstance(value, Usd.TimeCode):
            raise ValueError(f"Expected Usd.TimeCode, got: {value}")
        self._frame = value


class UsdviewApi:
    """Properties cannot be set, as in usdview."""

    __slots__ = ("_instances", "_model", "_paths", "_point", "_stage", "statuses", "updates")

    def __init__(self, stage, *, paths=("/",), instances=None, point=(0.0, 0.0, 0.0), frame=0.0):
        self._stage, self._model, self._point = stage, DataModel(Usd.TimeCode(frame)), point
        self._paths = [Sdf.Path(path) for path in paths]
        self._instances = instances or {}
        self.statuses, self.updates = [], 0

    dataModel = property(lambda self: self._model)
    stage = property(lambda self: self._stage)
    frame = property(lambda self: self._model.currentFrame)
    selectedPaths = property(lambda self: list(self._paths))
    selectedPrims = property(lambda self: [self._stage.GetPrimAtPath(path) for path in self._paths])
    selectedPoint = property(lambda self: self._point)
    qMainWindow = property(lambda self: None)

    @property
    def selectedInstances(self):
        return {prim: self._instances.get(prim.GetPath(), -1) for prim in self.selectedPrims}

    def ClearPrimSelection(self):
        self._paths = [Sdf.Path("/")]

    def AddPrimToSelection(self, prim):
        self._paths = [path for path in self._paths if path != Sdf.Path("/")] + [prim.GetPath()]

    def UpdateGUI(self):
        self.updates += 1

    def UpdateViewport(self):
        self.updates += 1

    def PrintStatus(self, msg):
        self.statuses.append(msg)


class Answers:
    """What the person at usdview answers to dialogs, in order; None = cancels."""

    def __init__(self, *answers):
        self.answers = list(answers)

    def getDouble(self, parent, title, label, value, minimum, maximum, decimals):
        answer = self.answers.pop(0)
        assert answer is None or minimum <= answer <= maximum
        return (value, False) if answer is None else (answer, True)

    def getItem(self, parent, title, label, items, current, editable):
        answer = self.answers.pop(0)
        return (items[current], False) if answer is None else (items[items.index(answer)], True)

    def getSaveFileName(self, parent, caption, directory, files):
        return self.answers.pop(0) or "", files


@contextmanager
def installed(answers):
    """pxr.Usdviewq as if usdview had imported it, with answers to the dialogs."""
    package, plugin, qt = (types.ModuleType(f"pxr.Usdviewq{name}") for name in ("", ".plugin", ".qt"))
    PluginContainer.__module__ = plugin.__name__
    plugin.PluginContainer = PluginContainer
    if Tf.Type.FindByName("pxr.Usdviewq.plugin.PluginContainer").isUnknown:
        Tf.Type.Define(PluginContainer)
    qt.QtWidgets = types.SimpleNamespace(QInputDialog=answers, QFileDialog=answers)
    modules = {module.__name__: module for module in (package, plugin, qt)}
    before = {name: module for name, module in sys.modules.items() if name.startswith("usdfoot.usdview")}
    sys.modules.update(modules)
    try:
        yield
    finally:
        for name in modules:
            del sys.modules[name]
        for name in [name for name in sys.modules if name.endswith(("usdview.actions", "usdview.dialogs"))]:
            if name not in before:
                del sys.modules[name]
