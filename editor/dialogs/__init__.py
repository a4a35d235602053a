"""Windows that come and go: open and save, progress, unsaved changes, welcome, help, the command palette.

dialogs.draw_all(ui)  once a frame, after the panels; each module has a class with draw(ui)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from editor.ui import Ui


class Dialogs:
    """All of them, with their state."""

    def __init__(self) -> None:
        from editor.dialogs import (
            arguments,
            cards,
            choose,
            files,
            import_card,
            modals,
            palette,
            pick_list,
            recovery,
            rename_asset,
        )
        from editor.plugins import windows as plugin_windows

        self.parts = (
            files.FileDialog(saving=False),
            files.FileDialog(saving=True),
            choose.ChooseDialog(),
            modals.ProgressModal(),
            modals.DiscardModal(),
            cards.WelcomeCard(),
            cards.HelpCard(),
            cards.AboutCard(),
            palette.Palette(),
            arguments.ArgumentsCard(),
            recovery.RecoveryModal(),
            pick_list.PickList(),
            rename_asset.RenameAsset(),
            import_card.ImportCard(),
            plugin_windows.TrustModal(),
            modals.Notice(),
        )

    def draw(self, ui: Ui) -> None:
        for part in self.parts:
            part.draw(ui)
