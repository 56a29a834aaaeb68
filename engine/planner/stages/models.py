"""The large models of a profile, as a planner uses them."""

from __future__ import annotations

from dataclasses import dataclass

from engine.llm.chain import Chain
from engine.llm.local import LocalChat


@dataclass(frozen=True, slots=True)
class Models:
    """One chain of models for each layer. Whoever makes them closes them."""

    execution: Chain
    decision: Chain | None = None
    local: LocalChat | None = None
    """The one of them that runs on this machine."""

    async def close(self) -> None:
        """Leave nothing of them behind."""
        await self.execution.close()
        if self.decision is not None:
            await self.decision.close()
