"""The program batten, run as a process: where it is, how far it is, how it is stopped, and what it says."""

import functools
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time

USUAL_PLACE = "/usr/bin/batten"
SECONDS_TO_STOP = 1.0  # after Ctrl-C; then it is killed


class Refusal(Exception):
    """Why there is no result, in a sentence for the user: the program's own where it was the program that refused."""


def candidates(preferred):
    """Where the program is looked for, in this order. A path in the preferences is the only one."""
    return [preferred] if preferred else [path for path in (shutil.which("batten"), USUAL_PLACE) if path]


@functools.lru_cache(maxsize=16)
def _version(path, _changed):
    """The version and no complaint, or a complaint: both are kept, because panels ask at every drawing."""
    remedy = "choose the program batten in the preferences of the add-on"
    try:
        run = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=30, check=False)
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        return "", f"{path} cannot be run: {error}; {remedy}"
    words = run.stdout.split()
    if run.returncode != 0 or len(words) != 2 or words[0] != "batten":
        return "", f"{path} is not the program batten; {remedy}"
    return words[1], ""


def find(preferred=""):
    """Path and version of the program. @raises Refusal where there is none."""
    for path in candidates(preferred):
        if os.path.isfile(path):
            version, complaint = _version(path, os.stat(path).st_mtime_ns)
            if complaint:
                raise Refusal(complaint)
            return path, version
        if preferred:
            raise Refusal(f"{path} is not a file; choose the program batten in the preferences of the add-on")
    raise Refusal(
        f"the program batten was found neither on PATH nor at {USUAL_PLACE}; "
        "install the package batten, or choose the program in the preferences of the add-on"
    )


class Run:
    """A run of the program in a temporary folder of its own. close() stops it and removes the folder."""

    def __init__(self, path, parent=None):
        self._path = path
        self.folder = tempfile.mkdtemp(prefix="batten-", dir=parent)
        self.stage = "starting"
        self._process = self._terminal = None
        self._said = b""
        self._names = {}

    def file(self, name, known_as=""):
        """A path in the folder. Sentences that name it say `known_as` instead."""
        path = os.path.join(self.folder, name)
        if known_as:
            self._names[path] = known_as
        return path

    def start(self, arguments):
        """Begins. The program tells how far it is only where it writes to a terminal: it is given one where there are any."""
        stderr = None
        try:
            self._terminal, stderr = os.openpty()
            os.set_blocking(self._terminal, False)
        except (AttributeError, OSError):
            stderr = os.open(self.file("stderr"), os.O_CREAT | os.O_WRONLY)
        try:
            with open(self.file("answer.json"), "wb") as answer:
                self._process = subprocess.Popen(
                    [self._path, *arguments, "--json"], stdin=subprocess.DEVNULL, stdout=answer, stderr=stderr
                )
        except OSError as error:
            raise Refusal(f"{self._path} cannot be run: {error}") from None
        finally:
            os.close(stderr)

    def poll(self):
        """What --json says once the program is done; None before. @raises Refusal where it refused or failed."""
        code = self._process.poll()
        self._listen()
        if code is None:
            return None
        with open(self.file("answer.json"), encoding="utf-8") as file:
            text = file.read()
        answer = json.loads(text) if text.strip() else {}
        if code == 0:
            return answer
        if "error" in answer:
            raise Refusal(self.in_words(answer["error"]["message"]))
        # Work that is not sound has its figures as the object, and its sentence beside it.
        sentences = re.findall(r"^batten: (.*)$", self._said.decode(errors="replace"), re.MULTILINE)
        raise Refusal(self.in_words(sentences[-1].strip()) if sentences else f"the program ended with the code {code}")

    def wait(self):
        """poll() until there is an answer."""
        while (answer := self.poll()) is None:
            time.sleep(0.01)
        return answer

    def in_words(self, sentence):
        for path, name in self._names.items():
            sentence = sentence.replace(path, name)
        return sentence

    def close(self):
        if self._process is not None and self._process.poll() is None:
            # What Ctrl-C does; other systems have only the end itself.
            self._process.send_signal(signal.SIGINT) if os.name == "posix" else self._process.terminate()
            try:
                self._process.wait(SECONDS_TO_STOP)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if self._terminal is not None:
            os.close(self._terminal)
            self._terminal = None
        shutil.rmtree(self.folder, ignore_errors=True)

    def _listen(self):
        if self._terminal is None:
            path = self.file("stderr")
            if os.path.exists(path):
                with open(path, "rb") as file:
                    self._said = file.read()
        else:
            try:
                while said := os.read(self._terminal, 65536):
                    self._said += said
            except OSError:
                pass  # nothing more for now, or for good
            # A line of progress is "\r\033[K", stage and percent; sentences stand alone without them.
            lines = re.split(rb"\r\x1b\[K|\r?\n", self._said)
            stages = [line for line in lines if re.fullmatch(rb"[^:]* +\d+ %", line)]
            if stages:
                self.stage = re.sub(r" +", " ", stages[-1].decode(errors="replace"))
            self._said = b"\n".join(line for line in lines if line not in stages)
