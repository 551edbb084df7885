"""The one thread that owns a Session: it takes commands between two frames, and renders while somebody watches."""

import queue
import threading
import traceback
from concurrent.futures import Future

import restirpg
from restirpg.harness import UserError

_IDLE = 0.25  # s between two looks for edited files while nothing is rendered


def told(error):
    """What a page shows of an exception: one line. Of one that is no user's mistake the traceback goes to stderr."""
    if isinstance(error, (UserError, restirpg.Error)):
        return str(error)
    traceback.print_exception(error)
    return f"{type(error).__name__}: {error}"


class RenderThread(threading.Thread):
    """`publish` is called here with what is new: state=..., frame=... or error=...

    watched: somebody looks, so frames are rendered, as they are for a film. wanted: somebody can take a picture, so it is
    made.
    """

    def __init__(self, session, publish, watch=None):
        super().__init__(name="restirpg viewer", daemon=True)
        self.watched = self.wanted = False
        self._session, self._publish, self._watch = session, publish, watch
        self._commands = queue.SimpleQueue()
        self._stopping = self._ended = False
        self._revision = -1
        self._failed = False  # the frame that was made last; it is tried again after a change

    def submit(self, function, *arguments):
        """Have function(*arguments) called between two frames. Returns a Future, which the thread's end cancels."""
        future = Future()
        self._commands.put((future, function, arguments))
        if self._ended:
            self._cancel_commands()
        return future

    def waiting(self):
        """How many commands wait for the frame at hand."""
        return self._commands.qsize()

    def set_audience(self, watched, wanted):
        """See the class. Any thread may call it."""
        woken = (watched and not self.watched) or (wanted and not self.wanted)
        self.watched, self.wanted = watched, wanted
        if woken:
            self.submit(lambda: None)

    def stop(self):
        """End the thread after the frame at hand."""
        self._stopping = True
        self.submit(lambda: None)
        self.join()

    def run(self):
        """Until stop()."""
        busy = False
        while not self._stopping:
            self._take_commands(wait=0 if busy else _IDLE)
            try:
                busy = self._advance()
            except Exception as error:  # shown; the session goes on
                self._report(error)
                busy = False
        self._ended = True
        self._cancel_commands()

    def _cancel_commands(self):
        """Whoever waits for one is told that it never comes."""
        try:
            while True:
                self._commands.get_nowait()[0].cancel()
        except queue.Empty:
            pass

    def _take_commands(self, wait):
        """All that wait now, until stop(); `wait`: seconds to wait for the first."""
        try:
            command = self._commands.get(timeout=wait) if wait else self._commands.get_nowait()
            self._call(*command)
            while not self._stopping:
                self._call(*self._commands.get_nowait())
        except queue.Empty:
            pass

    @staticmethod
    def _call(future, function, arguments):
        if not future.set_running_or_notify_cancel():  # nobody waits any more
            return
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)

    def _advance(self):
        """Render and show what there is to. Returns whether there may be more at once."""
        session = self._session
        if self._watch and self.watched and (files := self._watch.changed()):
            self._publish(note=f"reading anew: {', '.join(files[:3])}{' ...' if len(files) > 3 else ''}")
            session.apply({"do": "reload"})
        rendered = (self.watched or session.film is not None) and session.wants_frame()
        if rendered:
            session.render()
        if self.watched:
            rendered = session.trace_reference() or rendered
        if self._revision != session.revision:
            self._revision = session.revision
            self._failed = False
            self._publish(state=session.state())
        if self.wanted and session.stale and not self._failed:
            self._show()
        return rendered

    def _show(self):
        self._failed = True
        frame = self._session.frame()
        self._failed = False
        self.wanted = False  # until somebody has shown it
        self._publish(frame=frame)

    def _report(self, error):
        self._publish(error=told(error))
        self._publish(state=self._session.state())
