"""The report's page about browser_fixture.small_suite() in a headless Chromium, and what tests want to know of it."""
import json
import math
import os
import subprocess
import tempfile
import unittest

import browser
import browser_fixture as fixture

BUILD = "build"  # the build folder, whose bin/assay writes the page


# [smallest contrast of any text that is seen, where, how many texts]
WORST_CONTRAST = """(() => {
    const c = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
    const rgba = colour => { c.clearRect(0, 0, 1, 1); c.fillStyle = colour; c.fillRect(0, 0, 1, 1); return [...c.getImageData(0, 0, 1, 1).data].map(v => v / 255); };
    const light = ([r, g, b]) => [r, g, b].map(v => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4).reduce((s, v, i) => s + v * [.2126, .7152, .0722][i], 0);
    let found = [99, ''], count = 0;
    const root = document.querySelector('dialog[open]') ?? document.body;
    const walk = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
        const e = walk.currentNode.parentElement;
        if (!walk.currentNode.data.trim() || !e.checkVisibility({visibilityProperty: true}) || !e.getClientRects().length || e.closest('.unseen, script, [disabled], .label')) continue;
        let ground = [0, 0, 0, 0];
        for (let a = e; a && ground[3] < 1; a = a.parentElement) {
            const b = rgba(getComputedStyle(a).backgroundColor), w = b[3] * (1 - ground[3]);
            ground = [0, 1, 2].map(i => ground[i] + w * b[i]).concat(ground[3] + w);
        }
        const style = getComputedStyle(e), ink = rgba(e.closest('svg') ? style.fill : style.color);
        const [high, low] = [light(ink), light(ground)].sort((a, b) => b - a), ratio = (high + .05) / (low + .05);
        ++count;
        if (ratio < found[0]) found = [ratio, `${e.tagName}.${e.className} "${walk.currentNode.data.trim().slice(0, 40)}"`];
    }
    return [...found, count];
})()"""


def write_report(folder):
    html = os.path.join(folder, "report.html")
    subprocess.run([os.path.join(BUILD, "bin", "assay"), "report", "--build", folder, "-o", html], check=True, stdout=subprocess.DEVNULL)
    return html


def shown(radiance, exposure):
    """A pixel as the report must show it: ACES, then sRGB, in 8 bits."""
    if not all(map(math.isfinite, radiance)):
        return [255, 0, 255]
    out = []
    for value in radiance:
        x = .6 * float(value) * 2 ** exposure
        y = min(1, max(0, x * (2.51 * x + .03) / (x * (2.43 * x + .59) + .14)))
        out.append(255 * (12.92 * y if y <= .0031308 else 1.055 * y ** (1 / 2.4) - .055))
    return out


def number(text):
    return float(text.replace("−", "-"))


class ReportPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="assay-report-")
        cls.build = fixture.small_suite(cls.folder.name)
        cls.html = write_report(cls.folder.name)
        cls.page = browser.Page()

    @classmethod
    def tearDownClass(cls):
        cls.page.close()
        cls.folder.cleanup()

    def setUp(self):
        self.page.said.clear(), self.page.asked.clear()
        self.page.resize(1280, 900)
        self.page.media(prefers_color_scheme="light")
        self.load()

    def load(self, fragment=""):
        self.page.open("/dev/null")  # so that the next one is no mere change of the fragment
        self.page.asked.clear()
        self.page.open(self.html, fragment)
        self.page.wait("document.querySelectorAll('summary canvas[data-drawn]').length === 5")

    def tearDown(self):
        self.assertEqual(self.page.said, [], "on the console")
        self.assertEqual([a.split("#")[0] for a in self.page.asked if not a.startswith("data:")], ["file://" + self.html],
                         "the page asks for nothing but itself")

    # ---- helpers ----

    def js(self, expression):
        return self.page.evaluate(expression)

    def pixel(self, selector, x, y):
        # By way of a canvas of our own: reading the page's back would slow it down, and the console says so.
        return self.js(f"""(() => {{ const one = Object.assign(document.createElement('canvas'), {{width: 1, height: 1}}).getContext('2d');
            one.drawImage(document.querySelector({json.dumps(selector)}), -{x}, -{y}); return [...one.getImageData(0, 0, 1, 1).data]; }})()""")[:3]

    def assert_pixel(self, selector, x, y, expected, within=1.01):
        found = self.pixel(selector, x, y)
        for f, e in zip(found, expected):
            self.assertLessEqual(abs(f - e), within, f"{selector} at {x}, {y}: {found}, not {expected}")

    def enlarge(self, case, name="ours", group="golden"):
        self.js(f"document.getElementById('case-{case}').open = true")
        self.page.click(f"#case-{case} .shot[data-name='{name}'][data-group='{group}']")
        self.page.wait("document.querySelector('#viewer').open")

    def back(self):
        """Out of the large view; the page hears of it a moment later."""
        self.js("window.left = new Promise(heard => viewer.addEventListener('close', () => setTimeout(heard), {once: true})), 0")
        self.page.key("Escape")
        self.js("left")
        self.assertFalse(self.js("viewer.open"))

    def inspector(self):
        """{name: [numbers as text]}"""
        return self.js("""Object.fromEntries([...document.querySelectorAll('#v-values tr')].map(
            r => [r.querySelector('b').textContent, [...r.querySelectorAll('span span')].map(s => s.textContent)]))""")

    def go_to_pixel(self, x, y):
        """By keys, from the middle of the picture."""
        for key, count in (("ArrowRight", x - 10), ("ArrowDown", y - 6)):
            back = {"ArrowRight": "ArrowLeft", "ArrowDown": "ArrowUp"}[key]
            for _ in range(abs(count)):
                self.page.key(key if count > 0 else back)
        self.assertIn(f"pixel {x}, {y}", self.js("document.querySelector('#v-where').textContent"))
