"""What happened to a scene on its way into two renderers, in sentences (no Blender needed).

  changed  made alike in both pictures, because glTF has no word for it: the two pictures show the same thing, though
           not quite what the file would look like in Blender
  lost     in Blender's picture only: whatever differs there says nothing about either renderer
  known    where Blender 3.4.1 itself is known to be off (README, What it has found)
"""


class Failure(Exception):
    """Something a user can mend: one line, exit code 2."""


class Notes:
    KINDS = ("changed", "lost", "known")

    def __init__(self):
        for kind in self.KINDS:
            setattr(self, kind, [])

    def _add(self, kind, text):
        if text not in getattr(self, kind):
            getattr(self, kind).append(text)

    def change(self, text):
        self._add("changed", text)

    def lose(self, text):
        self._add("lost", text)

    def know(self, text):
        self._add("known", text)

    def json(self):
        return {kind: getattr(self, kind) for kind in self.KINDS}
