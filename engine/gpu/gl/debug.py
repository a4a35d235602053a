"""Errors of the driver: glGetError always, KHR_debug messages in debug."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

from engine.core.errors import DeviceError
from engine.gpu.gl import enums as e

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

_CALLBACK = ctypes.CFUNCTYPE(
    None, ctypes.c_uint, ctypes.c_uint, ctypes.c_uint, ctypes.c_uint, ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p
)
KEPT = 20


class DebugOutput:
    """Collects the driver's error messages between checks."""

    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._messages: list[str] = []
        self._callback: Any = None

    def listen(self) -> None:
        """Have the driver report errors in words, where it can (KHR_debug is core in 4.3)."""
        messages = self._messages

        def receive(
            source: int, kind: int, number: int, severity: int, length: int, message: bytes, user: object
        ) -> None:
            # shader logs are raised as ShaderError, with their place
            if kind == e.DEBUG_TYPE_ERROR and source != e.DEBUG_SOURCE_SHADER_COMPILER and len(messages) < KEPT:
                messages.append(message[:length].decode(errors="replace").strip())

        self._callback = _CALLBACK(receive)
        gl = self._device.gl
        gl.Enable(e.DEBUG_OUTPUT)
        gl.Enable(e.DEBUG_OUTPUT_SYNCHRONOUS)
        gl.DebugMessageCallback(ctypes.cast(self._callback, ctypes.c_void_p), None)

    def stop(self) -> None:
        if self._callback is not None:
            self._device.gl.DebugMessageCallback(None, None)
            self._device.gl.Disable(e.DEBUG_OUTPUT)
            self._callback = None

    def discard(self) -> None:
        """Forget what was noted so far."""
        for _ in range(KEPT):
            if self._device.gl.GetError() == e.NO_ERROR:
                break
        self._messages.clear()

    def check(self, where: str) -> None:
        """Raise DeviceError with all errors since the last check."""
        names = []
        for _ in range(KEPT):  # a lost context reports for ever
            code = self._device.gl.GetError()
            if code == e.NO_ERROR:
                break
            names.append(e.ERRORS.get(code, hex(code)))
        if names or self._messages:
            text = "; ".join([*names, *self._messages])
            self._messages.clear()
            raise DeviceError(f"OpenGL error in {where}: {text}", hint=_hint(names))


def _hint(names: list[str]) -> str:
    if "OUT_OF_MEMORY" in names:
        return "use smaller textures or a smaller picture, or close other programs"
    return "a defect of the backend or the driver"
