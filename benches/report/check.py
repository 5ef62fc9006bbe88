#!/usr/bin/env python3
"""Opens a report.html of `prt bench` in a browser and checks what it does.

    apt-get install chromium chromium-driver
    pip install -r benches/report/requirements.txt
    benches/report/check.py prt-bench/report.html [--screenshots DIR]

What should be on the page is worked out anew from its data: markers and frontier for every matrix and every pair of axes, the order of sorted
tables, what filters leave. Then: no error on the console, no request to anywhere, no NaN in a drawing, figures by pointer and by keys, a link that
brings a view back, the slider of pictures, files for papers, a PDF. Exits with 1 and a line for each promise that is broken. --screenshots
keeps pictures of the page at 1280 and 400 pixels and the PDF.
"""

import argparse
import base64
import json
import pathlib
import shutil
import sys
import tempfile
import time
import urllib.parse
import xml.etree.ElementTree as ElementTree

from expected import Data, frontier, is_number
from inside import COLLISIONS, COVERED, EVERY_PAIR
from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By


class Check:
    """A browser with the page, and what is wrong with it."""

    def __init__(self, path, screenshots):
        self.path, self.screenshots, self.broken = path.resolve(), screenshots, []
        self.data = Data(path)
        self.downloads = pathlib.Path(tempfile.mkdtemp())
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-ipc-flooding-protection"):
            options.add_argument(word)
        options.add_experimental_option("prefs", {"download.default_directory": str(self.downloads)})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        # The driver that is installed: without it Selenium would look for one on the network.
        self.browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        self.resize(1280)

    def expect(self, holds, otherwise):
        if not holds:
            self.broken.append(otherwise)

    def resize(self, width):
        # A window has a least width; the page may be narrower.
        metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        time.sleep(0.3)

    def open(self, **state):
        # Through an empty page: another hash alone would not load it again.
        self.browser.get("about:blank")
        self.browser.get(self.path.as_uri() + ("#" + urllib.parse.urlencode(state) if state else ""))
        time.sleep(0.3)

    def all(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def one(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def run(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def markers(self):
        return self.run("return [...document.querySelectorAll('#plane .point')].map((m) => [Number(m.dataset.row), m.getAttribute('transform')])")

    def choose(self, selector, value):
        self.run("const [s, v] = arguments; const e = document.querySelector(s); e.value = v; e.dispatchEvent(new Event('change', { bubbles: true }))", selector, value)

    def names(self):
        """The values by which the page knows its matrices, in their order."""
        return [value for value in self.run("return [...document.querySelectorAll('#matrix option')].map((o) => o.value)") if value != "all"]

    # What is promised

    def charts(self):
        self.open()
        names = self.names()
        self.expect(len(names) == len(self.data.groups), f"{len(names)} matrices can be chosen of {len(self.data.groups)}")
        for name, group in zip(names, self.data.groups):
            self.choose("#matrix", name)
            pairs = [pair for up in self.data.axes for pair in self.run(EVERY_PAIR, up, self.data.axes)]
            for up, across, drawn, best, strange in pairs:
                where = f"{name}, {up} against {across}"
                points = self.data.points(group, up, across)
                self.expect(sorted(drawn) == sorted(points), f"{where}: {len(drawn)} markers for {len(points)} rows")
                self.expect(set(best) == frontier(points), f"{where}: frontier {sorted(best)}, expected {sorted(frontier(points))}")
                self.expect(not strange, f"{where}: NaN, Infinity, undefined or null in the drawing")

    def small_multiples(self):
        if len(self.data.groups) < 2:
            return
        self.open(matrix="all")
        state = self.axes()
        for i, group in enumerate(self.data.groups):
            drawn = self.all(f"#plane .chart[data-group='{i}'] .point")
            expected = len(self.data.points(group, *state))
            self.expect(len(drawn) == expected, f"small chart {i}: {len(drawn)} markers for {expected} rows")
        self.expect(len(self.all("section.matrix:not([hidden])")) == len(self.data.groups), "a table is missing beside the small charts")

    def axes(self):
        return [self.one(f"#{key}").get_property("value") for key in ("up", "across")]

    def layout(self):
        for width in (1280, 400):
            self.resize(width)
            for state in ({}, {"matrix": "all"}):
                self.open(**state)
                needed = self.run("return document.documentElement.scrollWidth")
                self.expect(needed <= width, f"at {width} pixels the page is {needed} wide")
                for collision in self.run(COLLISIONS):
                    self.broken.append(f"at {width} pixels, {state or 'one matrix'}: {collision}")
        self.resize(1280)

    def pointer_and_keys(self):
        self.open()
        group = self.data.groups[0]
        for row, _ in self.markers():
            mark = self.one(f"#plane .point[data-row='{row}']")
            ActionChains(self.browser).move_to_element(mark).perform()
            label, tip = group["rows"][row]["method"], self.one("#tooltip").text
            covered = self.run(COVERED, mark)
            self.expect(label in tip or covered, f"pointing at {label} shows {tip.splitlines()[:1]}")
        ActionChains(self.browser).move_to_element(self.one("h1")).perform()
        self.run("document.querySelector('#plane .point[tabindex=\"0\"]').focus()")
        seen = {self.run("return document.activeElement.dataset.row")}
        for _ in self.markers():
            ActionChains(self.browser).send_keys(Keys.ARROW_RIGHT).perform()
            seen.add(self.run("return document.activeElement.dataset.row"))
        last = group["rows"][int(self.run("return document.activeElement.dataset.row"))]["method"]
        self.expect(len(seen) > len(self.markers()) / 2, f"arrow keys reach {len(seen)} of {len(self.markers())} markers")
        self.expect(last in self.one("#tooltip").text, f"the focus on {last} does not show its figures")
        ActionChains(self.browser).send_keys(Keys.ENTER).perform()
        line = self.all("tr.pinned")
        self.expect(len(line) == 1 and last in line[0].text, f"Enter on {last} does not mark its line")
        self.expect("pin=" in self.browser.current_url, "what is pinned is not in the link")
        ActionChains(self.browser).send_keys(Keys.ESCAPE).perform()
        self.expect(not self.all("tr.pinned"), "Escape does not let go")

    def filters(self):
        self.open()
        group, axes = self.data.groups[0], self.axes()
        for kind, keep in (("lossless", lambda r: r["error"] == 0), ("lossy", lambda r: is_number(r["error"]) and r["error"] > 0), ("all", lambda r: True)):
            self.one(f"#show [value='{kind}']").click()
            expected = sorted(self.data.points(group, *axes, keep))
            self.expect(sorted(row for row, _ in self.markers()) == expected, f"'{kind}' does not leave {len(expected)} markers")
        box = self.all("#families input")[0]
        family = box.get_property("value")
        box.click()
        expected = sorted(self.data.points(group, *axes, lambda r: r["family"] != family))
        self.expect(sorted(row for row, _ in self.markers()) == expected, f"without {family} there are not {len(expected)} markers")
        rows = [group["rows"][int(line.get_attribute("data-row"))] for line in self.all("section.matrix:not([hidden]) tbody tr") if line.is_displayed()]
        self.expect(rows and all(row["family"] != family for row in rows), f"lines of {family} stay in the table")
        self.one("#none").click()
        self.expect(not self.markers(), "'none' leaves markers")
        self.one("#every").click()
        self.expect(len(self.markers()) == len(self.data.points(group, *axes)), "'all' does not bring every marker back")

    def sorting(self):
        self.open()
        rows = self.data.groups[0]["rows"]
        for key in [h.get_attribute("data-key") for h in self.all("section.matrix:not([hidden]) thead th") if h.is_displayed()]:
            for order in ("ascending", "descending"):
                self.one(f"section.matrix:not([hidden]) th[data-key='{key}'] button").click()
                shown = [rows[int(line.get_attribute("data-row"))].get(key) for line in self.all("section.matrix:not([hidden]) tbody tr")]
                having = [value for value in shown if value is not None]
                said = self.one(f"section.matrix:not([hidden]) th[data-key='{key}']").get_attribute("aria-sort")
                self.expect(said == order, f"aria-sort of {key} is {said}, expected {order}")
                self.expect(having == sorted(having, reverse=order == "descending"), f"{key} is not {order}")
                self.expect(shown == having + [None] * (len(shown) - len(having)), f"{key}: lines without a figure are not last")
            self.one(f"section.matrix:not([hidden]) th[data-key='{key}'] button").click()

    def links(self):
        self.open()
        self.choose("#matrix", self.names()[-1])
        self.choose("#up", "file_bytes")
        self.choose("#across", self.data.axes[-1])
        self.all("#families input")[1].click()
        self.one("#show [value='lossy']").click()
        self.one("section.matrix:not([hidden]) th[data-key='method'] button").click()
        before, link = (self.markers(), self.axes()), self.browser.current_url
        self.browser.get("about:blank")
        self.browser.get(link)
        time.sleep(0.3)
        self.expect((self.markers(), self.axes()) == before, "the link does not bring the view back")
        self.expect(not self.all("#families input")[1].is_selected(), "the link forgets a family")
        self.expect(self.one("#matrix").get_property("value") == self.names()[-1], "the link forgets the matrix")
        self.expect(len(self.all("section.matrix:not([hidden]) th[aria-sort='ascending']")) == 1, "the link forgets the order")

    def pictures(self):
        expected = any(group["pictures"] for group in self.data.groups)
        self.open()
        self.expect(bool(self.all("#pictures")) == expected, "pictures are there without data, or the other way round")
        self.expect(bool(self.all("#selections")) == bool(self.data.data["selections"]), "selections are there without data, or the other way round")
        if not expected:
            return
        clip = lambda: self.one("#picture-method").value_of_css_property("clip-path")
        before = clip()
        self.one("#picture-split").send_keys(Keys.ARROW_RIGHT * 20)
        self.expect(clip() != before, "the slider does not move")
        broken = self.run("return [...document.querySelectorAll('#pictures img')].filter((i) => !i.complete || !i.naturalWidth).length")
        self.expect(broken == 0, f"{broken} pictures cannot be shown")
        source, buttons = self.one("#picture-method").get_attribute("src"), self.all("#thumbnails button")
        if len(buttons) > 1:
            buttons[1].click()
            chosen = self.all("#thumbnails button[aria-pressed='true']")
            self.expect(self.one("#picture-method").get_attribute("src") != source and len(chosen) == 1, "a method's button does not show its picture")

    def papers(self):
        self.open()
        for button in ("save-svg", "save-png"):
            self.one(f"#{button}").click()
        deadline = time.time() + 10
        found = lambda extension: list(self.downloads.glob(f"*.{extension}"))
        while time.time() < deadline and not (found("svg") and found("png")):
            time.sleep(0.1)
        self.expect(found("png") and found("png")[0].read_bytes()[:4] == b"\x89PNG", "no PNG is saved")
        self.expect(bool(found("svg")), "no SVG is saved")
        if found("svg"):
            text = found("svg")[0].read_text(encoding="utf-8")
            markers = [e for e in ElementTree.fromstring(text).iter() if "point" in e.get("class", "").split()]
            self.expect(len(markers) == len(self.markers()) and "NaN" not in text, "the saved SVG has other markers than the page")
        self.browser.execute_cdp_cmd("Browser.grantPermissions", {"permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"]})
        self.one("#copy-csv").click()
        time.sleep(0.3)
        copied = self.browser.execute_async_script("const [done] = arguments; navigator.clipboard.readText().then(done, (error) => done(String(error)))")
        self.expect(len(copied.splitlines()) == 1 + len(self.markers()), f"the copied CSV is {copied[:80]!r}")

    def paper(self):
        self.open()
        pdf = base64.b64decode(self.browser.print_page())
        self.expect(pdf.startswith(b"%PDF") and len(pdf) > 10_000, "the page cannot be printed")
        if self.screenshots:
            (self.screenshots / "print.pdf").write_bytes(pdf)

    def keep(self):
        """Pictures of the whole page."""
        if not self.screenshots:
            return
        for width in (1280, 400):
            self.resize(width)
            for name, state in (("one", {}), ("all", {"matrix": "all"})):
                self.open(**state)
                size = self.run("return [document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
                clip = {"x": 0, "y": 0, "width": size[0], "height": size[1], "scale": 1}
                shot = self.browser.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
                (self.screenshots / f"{name}-{width}.png").write_bytes(base64.b64decode(shot["data"]))

    def silence(self):
        """Nothing on the console, and nothing asked of anybody."""
        for entry in self.browser.get_log("browser"):
            self.broken.append(f"console: {entry['message']}")
        for entry in self.browser.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                url = message["params"]["request"]["url"]
                own = url.split("#")[0] == self.path.as_uri() or url.startswith(("data:", "blob:", "about:"))
                self.expect(own, f"asks for {url}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", type=pathlib.Path)
    parser.add_argument("--screenshots", type=pathlib.Path)
    arguments = parser.parse_args()
    if arguments.screenshots:
        arguments.screenshots.mkdir(parents=True, exist_ok=True)
    check = Check(arguments.report, arguments.screenshots)
    try:
        for promise in (check.charts, check.small_multiples, check.layout, check.pointer_and_keys, check.filters, check.sorting, check.links,
                        check.pictures, check.papers, check.paper, check.keep, check.silence):
            started = time.time()
            try:
                promise()
            except WebDriverException as error:
                check.broken.append(f"{promise.__name__}: {error.msg}")
            print(f"{promise.__name__}: {time.time() - started:.1f} s", flush=True)
    finally:
        check.browser.quit()
    for line in check.broken[:50]:
        print(f"broken: {line}")
    print(f"{len(check.broken)} broken" if check.broken else "every promise is kept")
    return 1 if check.broken else 0


if __name__ == "__main__":
    sys.exit(main())
