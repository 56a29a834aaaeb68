"""Models: the list of what can be fetched, and the folder that holds what was.

Nothing here loads a model; that is for the recogniser, the planner and the voice. They ask the store for a folder and
get either one whose files are complete, or an error that says which command fetches them.
"""

from engine.models.manifest import Manifest, Model, ModelFile
from engine.models.store import FileCheck, ModelStatus, ModelStore, Progress, Verification

__all__ = [
    "FileCheck",
    "Manifest",
    "Model",
    "ModelFile",
    "ModelStatus",
    "ModelStore",
    "Progress",
    "Verification",
]
