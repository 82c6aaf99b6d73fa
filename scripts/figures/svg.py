"""Line plots as SVG, the same bytes every time: a white card that reads on light and dark pages alike."""

import math

INK, FAINT, GRID = "#24292f", "#57606a", "#e4e7eb"
SIZE = 13


def escape(text):
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def number(x):
    text = "%.2f" % x
    return text.rstrip("0").rstrip(".") if "." in text else text


def clip(points, box):
    """The polyline cut to the box (x0, x1, y0, y1): a list of polylines (Liang and Barsky, segment by segment)."""
    x0, x1, y0, y1 = box
    pieces, piece = [], []
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        low, high = 0.0, 1.0
        for start, step, least, most in ((ax, bx - ax, x0, x1), (ay, by - ay, y0, y1)):
            if step == 0:
                if not least <= start <= most:
                    low, high = 1.0, 0.0
                continue
            enter, leave = sorted(((least - start) / step, (most - start) / step))
            low, high = max(low, enter), min(high, leave)
        if low > high:
            piece = []
            continue
        a, b = [(ax + t * (bx - ax), ay + t * (by - ay)) for t in (low, high)]
        if not piece or low > 0:
            piece = [a]
            pieces.append(piece)
        piece.append(b)
    return pieces


class Figure:
    def __init__(self, width, height, about):
        self.width, self.height = width, height
        self.parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" width="%d" height="%d" role="img" '
                      'font-family="system-ui, -apple-system, Segoe UI, DejaVu Sans, sans-serif" font-size="%d">'
                      % (width, height, width, height, SIZE), "<title>%s</title>" % escape(about),
                      '<rect x="0.5" y="0.5" width="%d" height="%d" rx="8" fill="#ffffff" stroke="#d0d7de"/>'
                      % (width - 1, height - 1)]

    def text(self, x, y, text, anchor="start", color=INK, size=None, bold=False, turn=False):
        extra = ' font-size="%d"' % size if size else ""
        extra += ' font-weight="600"' if bold else ""
        extra += ' transform="rotate(-90 %s %s)"' % (number(x), number(y)) if turn else ""
        self.parts.append('<text x="%s" y="%s" text-anchor="%s" fill="%s"%s>%s</text>'
                          % (number(x), number(y), anchor, color, extra, escape(text)))

    def path(self, points, color, width=2.0, dash=None, fill="none", opacity=None):
        data = "M" + "L".join("%s %s" % (number(x), number(y)) for x, y in points)
        extra = ' stroke-dasharray="%s"' % dash if dash else ""
        extra += ' fill-opacity="%s"' % opacity if opacity else ""
        self.parts.append('<path d="%s" fill="%s" stroke="%s" stroke-width="%s" stroke-linejoin="round"%s/>'
                          % (data, fill, color, number(width), extra))

    def legend(self, x, y, entries, title=None):
        """entries: (label, color, dash or None)."""
        if title:
            self.text(x, y, title, color=FAINT)
            y += 19
        for label, color, dash in entries:
            self.path([(x, y - 4), (x + 24, y - 4)], color, 2.5, dash)
            self.text(x + 31, y, label)
            y += 19

    def bytes(self):
        return ("\n".join(self.parts + ["</svg>"]) + "\n").encode()


class Panel:
    """Axes from x0 to x1 and y0 to y1 (`log`: the logarithm of y) in the rectangle (left, top, width, height)."""

    def __init__(self, figure, rectangle, x, y, title, x_label, y_label, log=False, x_unit=""):
        """x, y: lists of the ticks; their ends are those of the axes."""
        self.figure, self.rectangle, self.log = figure, rectangle, log
        self.x, self.y = (x[0], x[-1]), (self.scale(y[0]), self.scale(y[-1]))
        left, top, width, height = rectangle
        figure.text(left, top - 14, title, bold=True)
        for tick in x:
            px = self.at(tick, y[0])[0]
            figure.path([(px, top), (px, top + height)], GRID, 1)
            figure.text(px, top + height + 18, "%g%s" % (tick, x_unit), "middle", FAINT)
        for tick in y:
            py = self.at(x[0], tick)[1]
            figure.path([(left, py), (left + width, py)], GRID, 1)
            exponent = round(math.log10(tick)) if log else 0
            label = "%g" % tick if not log or -3 < exponent < 4 else "10" + "".join(
                "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(c)] for c in str(exponent))
            figure.text(left - 8, py + 4.5, label, "end", FAINT)
        figure.text(left + width / 2, top + height + 38, x_label, "middle")
        if y_label:
            figure.text(left - 44, top + height / 2, y_label, "middle", turn=True)
        figure.path([(left, top), (left, top + height), (left + width, top + height)], FAINT, 1)

    def scale(self, y):
        return math.log10(max(y, 1e-30)) if self.log else y

    def at(self, x, y):
        left, top, width, height = self.rectangle
        return (left + width * (x - self.x[0]) / (self.x[1] - self.x[0]),
                top + height * (1 - (self.scale(y) - self.y[0]) / (self.y[1] - self.y[0])))

    def line(self, points, color, width=2.0, dash=None):
        left, top, w, h = self.rectangle
        for piece in clip([self.at(*p) for p in points], (left, left + w, top, top + h)):
            self.figure.path(thin(piece), color, width, dash)

    def bars(self, points, step, color):
        """A histogram: bars of width `step` about each x, from the bottom."""
        floor = 10 ** self.y[0] if self.log else self.y[0]
        outline = []
        for x, y in points:
            outline += [self.at(x - step / 2, max(y, floor)), self.at(x + step / 2, max(y, floor))]
        ends = [self.at(points[0][0] - step / 2, floor)], [self.at(points[-1][0] + step / 2, floor)]
        self.figure.path(ends[0] + outline + ends[1], color, 0, fill=color, opacity=0.28)


def polar(figure, center, radius, rings, title, view, curves):
    """A half disc over the surface; angles from the normal, `rings`: the values of the rings, last the largest.
    view: the viewer's angle, dotted. curves: (points,
    color, dash)."""
    cx, cy = center
    place = lambda angle, r: (cx + r * math.sin(math.radians(angle)), cy - r * math.cos(math.radians(angle)))
    figure.text(cx - radius, cy - radius - 24, title, bold=True)
    for ring in rings:
        r = radius * ring / rings[-1]
        figure.path([place(a, r) for a in range(-90, 91, 5)], GRID, 1)
        figure.text(cx + r, cy + 18, "%g" % ring, "middle", FAINT)
    for angle in (-60, -30, 0, 30, 60):
        figure.path([(cx, cy), place(angle, radius)], GRID, 1)
        x, y = place(angle, radius + 11)
        figure.text(x, y + 4, "%d°" % angle, "middle", FAINT, 11)
    figure.path([(cx - radius, cy), (cx + radius, cy)], FAINT, 1)
    figure.path([place(-view, radius), (cx, cy)], FAINT, 1.5, "2 4")
    for points, color, dash in curves:
        figure.path(thin([place(angle, radius * value / rings[-1]) for angle, value in points]), color, 2, dash)


def thin(points):
    """Without the points that lie within a tenth of a pixel of the line between their neighbours that stay."""
    if len(points) < 3:
        return points
    (ax, ay), (bx, by) = points[0], points[-1]
    length = math.hypot(bx - ax, by - ay)

    def distance(p):
        if length == 0:
            return math.hypot(p[0] - ax, p[1] - ay)
        return abs((bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax)) / length

    far = max(range(1, len(points) - 1), key=lambda i: distance(points[i]))
    if distance(points[far]) < 0.1:
        return [points[0], points[-1]]
    return thin(points[:far + 1])[:-1] + thin(points[far:])
