"""The extension: (status, text, crashed) of each call."""

from typing import Optional, Tuple

version: str
build: str

_Answer = Tuple[int, bytes, bool]
_Settings = list[Tuple[str, str]]

def run(file: bytes, text: Optional[str], settings: _Settings, level: str, images: bool, check: bool,
        pictures: int) -> _Answer: ...
def analyze(file: bytes, text: Optional[str], settings: _Settings, frame_rate_hz: Optional[float]) -> _Answer: ...
def sweep(file: bytes, text: Optional[str], out: bytes, processes: Optional[int], time_limit: Optional[float], level: str,
          quiet: bool) -> _Answer: ...
def size(file: bytes, settings: _Settings, minimize: str, over: list[str], goal: str, frame_rate_hz: Optional[float],
         checks: Optional[int], out: bytes, processes: Optional[int], time_limit: Optional[float], level: str,
         quiet: bool) -> _Answer: ...
def results(file: bytes, where: str, columns: str) -> _Answer: ...
