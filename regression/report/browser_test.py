#!/usr/bin/env python3
"""The report in a headless Chromium: scripted clicks and keys, and what the page then shows.

    browser_test.py BUILD_FOLDER [unittest's arguments]      exit code 77: cannot run here, and says why

Pictures are compared with values computed here in double precision from what the EXR files hold.
"""
import math
import os
import sys
import tempfile
import unittest

import browser

if not browser.program():
    print("skipped: no chromium (Debian's package chromium) on this machine")
    sys.exit(77)
try:
    import browser_fixture as fixture
    import browser_page
    from browser_page import number, shown
except ImportError as missing:
    print(f"skipped: {missing} (Debian's python3-numpy and python3-openimageio; run with /usr/bin/python3)")
    sys.exit(77)
if __name__ == "__main__" and len(sys.argv) > 1:
    browser_page.BUILD = sys.argv.pop(1)


class ReportTest(browser_page.ReportPage):
    # ---- the list ----

    def test_failures_come_first_and_are_open(self):
        cases = self.js("[...document.querySelectorAll('.case')].map(c => [c.dataset.name, c.open])")
        self.assertEqual(cases, [["bright", True], ["broken", True], ["same", False], ["normals", False], ["large", False]])
        self.assertEqual(self.js("document.querySelector('h1').textContent"), "Assay failed")

    def test_exposure_works_on_the_floats_of_the_list(self):
        canvas = "#case-bright .shot[data-name=ours] canvas"
        ours = self.build.pixels["renders/bright.exr"]
        self.page.wait(f"document.querySelector('{canvas}').dataset.stops === '0'")
        places = [(2, 3), (0, 0), (19, 11), (13, 5), (7, 9)]
        for x, y in places:
            self.assert_pixel(canvas, x, y, shown(ours[y, x], 2))  # the middle of the stored exposures
        for _ in range(6):
            self.page.key("[")
        self.page.wait(f"document.querySelector('{canvas}').dataset.stops === '-3'")
        for x, y in places:
            self.assert_pixel(canvas, x, y, shown(ours[y, x], -1))
        self.assertEqual(self.js("document.querySelector('.exposure output').textContent"), "−3")
        self.page.click(".filters .exposure input")  # its middle is 0
        self.page.key("ArrowRight")
        self.page.wait(f"document.querySelector('{canvas}').dataset.stops === '0.25'")
        self.assert_pixel(canvas, 13, 5, shown(ours[5, 13], 2.25))

    def test_filters_count_what_they_would_show_and_combine(self):
        shown_cases = "[...document.querySelectorAll('.case')].filter(c => !c.hidden && c.offsetHeight).map(c => c.dataset.name)"
        counts = "Object.fromEntries([...document.querySelectorAll('.filters [data-word]')].map(b => [b.dataset.word, Number(b.querySelector('b').textContent)]))"
        status = "document.querySelector('#count').textContent"
        self.assertEqual(self.js(counts), {
            "status:failing": 2, "status:passing": 3, "status:pending": 2, "verdict:BROKEN": 1, "verdict:CHANGED": 1,
            "verdict:IDENTICAL": 3, "witness:AGREES": 1, "witness:DIFFERS": 1, "by:Blender": 1, "by:POV-Ray": 1,
            "tag:disney": 3, "tag:geometry": 2, "tag:light": 2})
        self.page.click("[data-word='tag:disney']")
        self.assertEqual(self.js(shown_cases), ["bright", "same", "normals"])
        self.assertEqual(self.js(status), "3 of 5 cases")
        now = self.js(counts)
        self.assertEqual((now["verdict:IDENTICAL"], now["verdict:BROKEN"], now["tag:light"]), (2, 0, 2),
                         "other groups narrow down, the own group does not")
        self.page.click("[data-word='verdict:IDENTICAL']")
        self.assertEqual(self.js(shown_cases), ["same", "normals"])
        self.page.click("[data-word='witness:AGREES']")
        self.assertEqual(self.js(shown_cases), ["normals"])
        self.assertEqual(self.js("document.querySelector(\"[data-word='witness:AGREES']\").getAttribute('aria-pressed')"), "true")
        self.page.click("[data-word='witness:AGREES']")  # again: free
        self.page.key("/")
        self.page.write("notices same")
        self.assertEqual(self.js(shown_cases), ["same"])
        self.page.write(" nothing")
        self.assertEqual(self.js(shown_cases), [])
        self.assertTrue(self.js("!document.querySelector('#nothing').hidden"))
        self.page.click("#clear")
        self.page.key("/")
        self.page.write("povray")
        self.assertEqual(self.js(shown_cases), ["normals"])
        self.page.click("#clear")
        self.assertEqual(self.js(status), "5 of 5 cases")

    def test_keys_move_through_the_list(self):
        focused = "document.activeElement.closest('.case')?.dataset.name"
        for key, name in (("j", "bright"), ("j", "broken"), ("k", "bright"), ("k", "bright"), ("j", "broken"), ("j", "same")):
            self.page.key(key)
            self.assertEqual(self.js(focused), name)
        self.page.key("Enter")
        self.assertTrue(self.js("document.querySelector('#case-same').open"))
        for width in (1280, 800):  # the filters take more rows in a narrower window, and never hide what has the focus
            self.page.resize(width, 500)
            self.page.evaluate("new Promise(requestAnimationFrame).then(() => 0)")
            self.page.key("k"), self.page.key("k"), self.page.key("j")
            below = self.js("document.activeElement.getBoundingClientRect().top - document.querySelector('.filters').getBoundingClientRect().bottom")
            self.assertGreaterEqual(below, 0)
            self.page.key("j")
        self.page.key("v")
        self.page.wait("document.querySelector('#viewer').open")
        self.assertEqual(self.js("document.querySelector('#v-case').textContent"), "same")

    def test_a_link_opens_its_case(self):
        self.load("#case-normals")
        self.assertTrue(self.js("document.querySelector('#case-normals').open"))

    def test_commands_to_accept_are_exact_and_can_be_copied(self):
        codes = self.js("[...document.querySelectorAll('.accept code')].map(c => c.textContent)")
        self.assertEqual(codes, ["build/bin/assay accept bright broken --because \"…\"", "build/bin/assay accept bright --because \"…\"",
                                 "build/bin/assay accept broken --because \"…\""])
        self.page.send("Browser.grantPermissions", permissions=["clipboardReadWrite", "clipboardSanitizedWrite"])
        self.page.click("#case-bright .copy")
        self.page.wait("document.querySelector('#case-bright .copy').textContent === 'Copied'")
        self.assertEqual(self.js("navigator.clipboard.readText()"), codes[1])

    def test_the_table_of_witnesses_tells_noise_bias_and_model_apart(self):
        self.page.click("#witnesses summary")
        rows = self.js("[...document.querySelectorAll('#witnesses tbody tr')].map(r => r.innerText)")
        self.assertEqual(len(rows), 2)
        # Ours: golden with 10 % more in one half and one pixel of 20000; Blender: golden x 1.05. Model dominates.
        ours, theirs = (self.build.pixels[p].astype(float) for p in ("renders/bright.exr", "reference/bright.exr"))
        d, scale = ours - theirs, abs(theirs).mean()
        noise = 2e-4
        bias = ((d.mean((0, 1)) ** 2) - noise / d[..., 0].size).mean()
        model = (d * d).mean() - noise - bias
        for share in (noise, model):
            percent = 100 * math.sqrt(share) / scale
            self.assertIn(f"{percent:.0f} %" if percent >= 1000 else f"{percent:.3g} %", rows[0])
        self.page.click("#witnesses tbody a")
        self.assertEqual(self.js("location.hash"), "#case-bright")

    # ---- the large view ----

    def test_the_keys_of_the_large_view_choose_pictures_and_views(self):
        self.enlarge("bright")
        ours, golden = self.build.pixels["renders/bright.exr"], self.build.pixels["goldens/bright.exr"]
        pressed = "document.querySelector('#v-tabs [aria-pressed=true]').textContent"
        state = lambda: (self.js(pressed), self.js("document.querySelector('#v-tabs .other').textContent"), self.js("viewer.dataset.mode"))
        self.assertEqual(state(), ("1ours", "2golden", "one"))
        self.assert_pixel("#v-canvas", 15, 4, shown(ours[4, 15], 2))
        self.page.key(" ")
        self.assertEqual(state(), ("2golden", "1ours", "one"))
        self.assert_pixel("#v-canvas", 15, 4, shown(golden[4, 15], 2))
        self.page.key("x")
        for key, name in (("f", "3FLIP"), ("d", "4difference"), ("m", "5significance"), ("g", "2golden"), ("r", "1ours"), ("6", "6Blender"), ("m", "9significance")):
            self.page.key(key)
            self.assertEqual(self.js(pressed), name)
        self.page.key("1"), self.page.key("2")
        for key, mode in (("w", "wipe"), ("s", "side"), ("b", "blend"), ("o", "one"), ("w", "wipe"), ("w", "one")):
            self.page.key(key)
            self.assertEqual(state(), ("2golden", "1ours", mode))
        self.page.click("#v-tabs button:nth-of-type(3)")
        self.assertEqual(state(), ("3FLIP", "2golden", "one"))
        self.page.key(" ")
        self.assertEqual(state(), ("2golden", "3FLIP", "one"), "a click leaves the keys to the picture")
        self.page.key("j")
        self.page.wait("document.querySelector('#v-case').textContent === 'broken'")
        self.page.key("k")
        self.page.wait("document.querySelector('#v-case').textContent === 'bright'")
        self.back()
        self.assertEqual(self.js("document.activeElement.dataset.name"), "golden", "focus returns to the picture last seen")

    def test_exposure_of_the_large_view_is_that_of_the_floats(self):
        self.enlarge("bright")
        ours = self.build.pixels["renders/bright.exr"]
        for presses, key, exposure in ((9, "[", -2.5), (3, "]", -1), (1, "\\", 2), (7, "]", 5.5), (1, "\\", 2)):
            for _ in range(presses):
                self.page.key(key)
            for x, y in ((2, 3), (0, 0), (19, 11), (13, 5)):
                self.assert_pixel("#v-canvas", x, y, shown(ours[y, x], exposure))
        # 20000 is far beyond a PNG: fourteen stops down it is a middle grey. The slider ends at -8.
        for _ in range(16):
            self.page.key("[")
        self.assert_pixel("#v-canvas", 2, 3, shown(ours[3, 2], -6))
        self.assertEqual(self.js("document.querySelector('#viewer .exposure output').textContent"), "−8")

    def test_the_wipe_can_be_dragged_and_moved_by_keys(self):
        self.enlarge("bright")
        self.page.key("w")
        clip = lambda: float(self.js("document.querySelector('#v-over').style.clipPath").split()[-1].rstrip("%)"))
        self.assertAlmostEqual(clip(), 50)
        golden = self.build.pixels["goldens/bright.exr"]
        self.assert_pixel("#v-over", 15, 4, shown(golden[4, 15], 2))
        left, top, width, height = self.js("(b => [b.left, b.top, b.width, b.height])(document.querySelector('#v-canvas').getBoundingClientRect())")
        y = top + height / 2
        self.page.drag((left + width / 2, y), (left + .8 * width, y))
        self.assertAlmostEqual(clip(), 80, delta=.5)
        box = self.js("(b => b.left + b.width / 2)(document.querySelector('#v-handle').getBoundingClientRect())")
        self.assertAlmostEqual(box, left + .8 * width, delta=1.5)
        self.assertIn(self.js("document.querySelector('#v-mix').value"), ("79", "80", "81"))
        self.page.key(","), self.page.key(",")
        self.assertAlmostEqual(clip(), 70, delta=.5)
        self.page.drag((left + .7 * width, y), (left - 500, y))
        self.assertEqual(clip(), 0)
        self.page.key("b")
        self.page.key(".")
        self.assertEqual(self.js("document.querySelector('#v-over').style.opacity"), "0.05")
        self.page.key("s")
        visible = self.js("document.querySelector('#v-second').offsetWidth > 100 && !document.querySelector('#v-over').offsetWidth")
        self.assertTrue(visible)
        self.assert_pixel("#v-beside", 15, 4, shown(golden[4, 15], 2))

    def test_the_inspector_has_the_values_of_the_files(self):
        files = {"ours": "renders/bright.exr", "golden": "goldens/bright.exr", "Blender": "reference/bright.exr"}
        for x, y in ((13, 5), (2, 3), (19, 11)):
            if self.js("viewer.open"):
                self.back()
            self.enlarge("bright")
            self.go_to_pixel(x, y)
            values = self.inspector()
            self.assertEqual(len(values), 9)
            for name, file in files.items():
                for text, exact in zip(values[name], self.build.pixels[file][y, x]):
                    # Half a unit of a half's last place, and of the fourth digit; below the smallest half there is nothing.
                    largest = self.build.pixels[file].max()
                    self.assertLessEqual(abs(number(text) - exact), (2 ** -12 + 5e-4) * exact + largest * 2 ** -38, f"{name} {values[name]}")
            for text, a, b in zip(values["difference, golden"], *(self.build.pixels[files[n]][y, x] for n in ("ours", "golden"))):
                self.assertAlmostEqual(number(text), float(a) - float(b), delta=1e-3 * abs(float(a) - float(b)) + 2e-4)
            flip = self.build.pixels["results/bright.flip.exr"][y, x, 0]
            self.assertAlmostEqual(number(values["FLIP, golden"][0]), flip, delta=1e-3)
            tile = next(t for t in fixture.TILES if t[0] <= x < t[0] + t[2] and t[1] <= y < t[1] + t[3])
            self.assertEqual(values["significance, golden"], [f"t {tile[4]:g}".replace("-", "−")])
            self.assertIn(f"tile {tile[0]}, {tile[1]} (golden): luminance +8 % [+7 %, +9 %]", self.js("document.querySelector('#v-tile').textContent"))
            # The loupe's middle is the pixel.
            self.assertEqual(self.pixel("#v-values canvas", 20, 20), self.pixel("#v-canvas", x, y))

    def test_the_pointer_inspects_pins_zooms_and_moves(self):
        self.enlarge("bright")
        where = lambda: self.js("document.querySelector('#v-where').textContent")
        box = lambda: self.js("(b => [b.left, b.top, b.width, b.height])(document.querySelector('#v-canvas').getBoundingClientRect())")
        on = lambda x, y: (box()[0] + (x + .5) * box()[2] / fixture.WIDTH, box()[1] + (y + .5) * box()[3] / fixture.HEIGHT)
        self.page.mouse("Moved", *on(4, 7))
        self.assertEqual(where(), "pixel 4, 7")
        self.page.click_at(*on(5, 2))
        self.assertEqual(where(), "pixel 5, 2 · pinned")
        self.page.mouse("Moved", *on(10, 10))
        self.assertEqual(where(), "pixel 5, 2 · pinned")
        place, before = on(15, 9), box()
        self.page.mouse("Wheel", *place, deltaX=0, deltaY=-100)
        self.assertGreater(box()[2], before[2])
        for a, b in zip(place, on(15, 9)):
            self.assertAlmostEqual(a, b, delta=1.5, msg="the pixel under the pointer stays")
        before = box()
        self.page.drag((500, 500), (560, 470))
        self.assertAlmostEqual(box()[0] - before[0], 60, delta=1.5)
        self.assertAlmostEqual(box()[1] - before[1], -30, delta=1.5)
        self.page.click("#v-fit")
        self.page.key("+")
        larger = box()[2]
        self.page.key("0")
        self.assertLess(box()[2], larger)
        self.page.click_at(*on(5, 2))
        self.page.mouse("Moved", *on(10, 10))
        self.assertEqual(where(), "pixel 10, 10", "clicked again it is free")

    def test_a_wrong_pixel_is_shown_by_its_button(self):
        self.page.click("#case-bright .pixel")
        self.page.wait("viewer.open && here_is('pixel 2, 3 · pinned')".replace("here_is", "(t => document.querySelector('#v-where').textContent === t)"))
        self.assertEqual(self.inspector()["ours"][0], "20000")
        self.assertGreaterEqual(float(self.js("viewer.dataset.zoom")), 16)

    def test_maps_differences_and_tiles_have_their_colours(self):
        self.enlarge("bright", "difference")
        button = "document.querySelector(\"#case-bright .shot[data-name=difference]\")"
        gain = float(self.js(button + ".dataset.gain"))
        d = self.build.pixels["renders/bright.exr"].astype(float) - self.build.pixels["goldens/bright.exr"]
        for x, y in ((15, 4), (3, 3), (2, 3)):
            v = max(d[y, x], key=abs) * gain
            t = min(abs(v), 1)
            ramp = [255 * min(1, 2 * t), 255 * .8 * t, 255 * .5 * max(0, 2 * t - 1)]
            self.assert_pixel("#v-canvas", x, y, ramp if v >= 0 else ramp[::-1], 1.5)
        self.page.key("f")
        self.assert_pixel("#v-canvas", 0, 0, (0, 0, 4), 6)       # matplotlib's magma(0), magma(255)
        self.assert_pixel("#v-canvas", 19, 11, (252, 253, 191), 6)
        self.page.key("m")
        self.assert_pixel("#v-canvas", 0, 0, (255, 204, 127.5))   # t 9.5: beyond full colour, ours brighter
        self.assert_pixel("#v-canvas", 8, 7, (127.5, 204, 255))   # t -6.7
        self.assert_pixel("#v-canvas", 17, 9, (255, 102, 0))      # t 3.35: half
        self.assert_pixel("#v-canvas", 3, 9, (0, 0, 0))
        self.assert_pixel("#v-canvas", 9, 9, (255, 0, 255))       # no t
        self.back()
        self.enlarge("broken")
        self.assert_pixel("#v-canvas", 1, 1, (255, 0, 255))       # not a number
        self.back()
        self.enlarge("normals", "POV-Ray normal", "POV-Ray normal")
        self.assert_pixel("#v-canvas", 0, 0, (0, 0, 0))
        self.assert_pixel("#v-canvas", 19, 11, (255, 255, 255))

    def test_a_picture_too_large_for_floats_is_a_png_and_says_so(self):
        self.enlarge("large", "ours = golden")
        self.assert_pixel("#v-canvas", 300, 200, shown((.25, .5, 1), 2))
        self.page.key("ArrowUp")
        self.assertTrue(all(v.endswith("/255") for v in self.inspector()["ours = golden"]))
        self.page.key("]")
        self.assert_pixel("#v-canvas", 300, 200, shown((.25, .5, 1), 2))
        self.assertIn("not exposed", self.js("document.querySelector('#v-said').textContent"))

    def test_the_question_mark_shows_every_key(self):
        self.page.key("?")
        self.assertTrue(self.js("document.querySelector('#help').open"))
        documented = set(self.js("[...document.querySelectorAll('#help kbd')].map(k => k.textContent)"))
        self.assertTrue({"/", "j", "k", "v", "x", "o", "w", "s", "b", "r", "g", "d", "f", "m", "p", ",", ".", "[", "]", "\\", "0", "Esc"} <= documented)
        self.page.key("Escape")
        self.assertFalse(self.js("document.querySelector('#help').open"))
        self.enlarge("bright")
        self.page.key("?")
        self.page.key("w")
        self.assertEqual(self.js("viewer.dataset.mode"), "one", "keys below the help do nothing")
        self.page.key("Escape")
        self.assertEqual(self.js("[help.open, viewer.open]"), [False, True])

    # ---- for everybody ----

    def test_everything_to_press_has_a_name_and_focus_goes_in_order(self):
        self.js("document.querySelectorAll('.case').forEach(c => c.open = true)")
        for _ in range(2):  # the list, then the large view
            nodes = self.page.send("Accessibility.getFullAXTree")["nodes"]
            roles = {"button", "slider", "searchbox", "link", "application", "dialog"}
            pressable = [n for n in nodes if n.get("role", {}).get("value") in roles and not n.get("ignored")]
            self.assertGreater(len(pressable), 15)
            for n in pressable:
                self.assertTrue(n.get("name", {}).get("value"), f"no name: {n['role']} {n.get('properties')}")
            self.assertEqual(self.js("document.querySelectorAll('[tabindex]:not([tabindex=\"0\"])').length"), 0)
            self.js("window.last = null; window.passed = 0; (document.querySelector('dialog[open]') ?? document.body).focus()")
            for _ in range(30):
                self.page.key("Tab")
                self.assertTrue(self.js("""(() => { const e = document.activeElement, before = last; last = e;
                    if (e === document.body) return true;
                    passed += 1;
                    return getComputedStyle(e).outlineStyle !== 'none' || e.type === 'range' && e.matches(':focus-visible'); })()"""))
            self.assertGreater(self.js("passed"), 20)
            if self.js("viewer.open"):
                self.back()
            else:
                self.enlarge("bright")
        order = self.js("[...document.querySelectorAll('button, input, summary, a')].every(e => e.tabIndex === 0)")
        self.assertTrue(order, "the document's own order")

    def test_text_has_contrast_in_light_and_dark(self):
        for scheme in ("light", "dark"):
            self.page.media(prefers_color_scheme=scheme)
            self.js("document.querySelectorAll('details').forEach(d => d.open = true)")
            ratio, where, count = self.js(browser_page.WORST_CONTRAST)
            self.assertGreater(count, 150)
            self.assertGreaterEqual(ratio, 4.5, f"{scheme}: {where}")
            self.enlarge("bright")
            self.page.key("ArrowLeft")
            ratio, where, _ = self.js(browser_page.WORST_CONTRAST)
            self.assertGreaterEqual(ratio, 4.5, f"{scheme}, large view: {where}")
            self.page.key("?")
            ratio, where, _ = self.js(browser_page.WORST_CONTRAST)
            self.assertGreaterEqual(ratio, 4.5, f"{scheme}, keys: {where}")
            self.page.key("Escape")
            self.back()

    def test_a_narrow_window_needs_no_sideways_scrolling(self):
        self.page.resize(360, 740)
        self.js("document.querySelectorAll('details').forEach(d => d.open = true)")
        self.assertLessEqual(self.js("document.documentElement.scrollWidth"), 360)
        self.enlarge("bright")
        self.page.key("s")
        wide = self.js("[...document.querySelectorAll('#viewer, #viewer > *')].map(e => e.scrollWidth)")
        self.assertLessEqual(max(wide), 360)
        self.assertGreater(self.js("document.querySelector('#v-stage').clientHeight"), 250)

    def test_nothing_moves_by_itself(self):
        for motion in ("no-preference", "reduce"):
            self.page.media(prefers_reduced_motion=motion)
            self.enlarge("bright")
            self.page.key("w"), self.page.key("s")
            self.assertEqual(self.js("document.getAnimations().length"), 0)
            self.back()


class HundredCases(unittest.TestCase):
    def test_a_hundred_cases_are_below_15_MB_and_quick_to_filter(self):
        with tempfile.TemporaryDirectory(prefix="assay-report-") as folder:
            fixture.hundred_cases(folder)
            html = browser_page.write_report(folder)
            size = os.path.getsize(html)
            page = browser.Page()
            try:
                page.open(html)
                page.wait("document.querySelectorAll('summary canvas[data-drawn]').length === 100", 60)
                took = page.evaluate("""(() => { const t = performance.now(); for (const l of ['c', 'ca', 'case1', '']) {
                    document.querySelector('#search').value = l; document.querySelector('#search').dispatchEvent(new Event('input')); }
                    return (performance.now() - t) / 4; })()""")
                print(f"a hundred cases: {size / 1e6:.2f} MB; a letter in the search takes {took:.1f} ms")
                self.assertEqual(page.evaluate("document.querySelector('#count').textContent"), "100 of 100 cases")
                self.assertEqual(page.evaluate("document.querySelectorAll('.shot:not([data-floats], [data-tiles])').length"), 0,
                                 "every picture has its floats")
                self.assertEqual(page.said, [])
            finally:
                page.close()
            self.assertLessEqual(size, 15e6)
            self.assertLess(took, 500)


if __name__ == "__main__":
    unittest.main()
