"""Tests scripts/mutate on a tree of one source file and one test program.

usage: mutate_test.py SCRIPT
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SCRIPT = sys.argv[1]

CMAKE = """cmake_minimum_required(VERSION 3.25)
project(tiny LANGUAGES CXX)
enable_testing()
add_executable(gate_test model/rtl/gate.cpp tb/gate_test.cpp)
target_include_directories(gate_test PRIVATE model)
add_test(NAME "rtl: gate" COMMAND gate_test)
"""

SOURCE = """#include "rtl/gate.h"

int Gate::step(int value) {
    if (value < limit_) {
        ++steps_;
        return value + 1;
    }
    return value;
}

int Gate::run() {
    int value = 0;
    while (value != limit_) {
        value = step(value);
    }
    return steps_;
}

const char* Gate::name() const {
    return "gate";
}

int Gate::never_called() const { return limit_ - 1; }

int Gate::size() const { return size_of<2>(); }
"""

HEADER = """#pragma once

template <int kSize>
int size_of() {
    static_assert(kSize == 2);
    return kSize;
}

class Gate {
  public:
    explicit Gate(int limit) : limit_(limit) {}
    int step(int value);
    int run();
    const char* name() const;
    int never_called() const;
    int size() const;

  private:
    int limit_;
    int steps_ = 0;
};
"""

# Does not test what step() does at the limit.
TEST = """#include "rtl/gate.h"

int main() {
    Gate gate(3);
    return gate.step(0) == 1 && Gate(3).run() == 3 ? 0 : 1;
}
"""

FILE = "model/rtl/gate.cpp"
WRITTEN = [
    {"file": FILE, "what": "a step too few", "original": "        ++steps_;\n        return value + 1;",
     "replacement": "        return value + 1;"},
    {"file": FILE, "what": "no such type", "original": "return \"gate\";", "replacement": "return NoSuchName;"},
]
AT_LIMIT = {"file": FILE, "original": "value < limit_", "replacement": "value <= limit_", "reason": "never asked"}
NEGATED = {"file": FILE, "original": "value < limit_", "replacement": "!(value < limit_)", "reason": "wrong"}
UNREACHED = [{"file": FILE, "original": "return limit_ - 1;", "replacement": text, "reason": "never called"}
             for text in ("return limit_ + 1;", "return limit_ - 0;", "return limit_ - 2;")]
UNREACHED.append({"file": FILE, "original": "return value;", "replacement": "", "reason": "made by no operator"})


class Mutate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.tree = pathlib.Path(scratch.name)
        for name, text in [("CMakeLists.txt", CMAKE), (FILE, SOURCE), ("model/rtl/gate.h", HEADER),
                           ("tb/gate_test.cpp", TEST)]:
            cls.write(name, text)
        cls.write("tb/mutation/written.json", json.dumps(WRITTEN))
        cls.write("tb/mutation/equivalent.json", "[]")
        cls.write("table.md", "before\n<!-- mutants by block -->\nold\n<!-- end of mutants by block -->\nafter\n"
                  + "".join(f"<!-- {one} -->\n<!-- end of {one} -->\n" for one in
                            ("operators", "tests", "equivalent mutants")))
        cls.first = cls.mutate("--write-table", cls.tree / "table.md")
        cls.first_results = cls.results()

    @classmethod
    def write(cls, name, text):
        path = cls.tree / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    @classmethod
    def mutate(cls, *arguments):
        return subprocess.run([SCRIPT, "--source", cls.tree, "--timeout", "2", *arguments],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=300, check=False)

    @classmethod
    def results(cls):
        return json.loads((cls.tree / "build/mutate/results.json").read_text())["mutants"]

    def again(self, equivalent):
        """Judges again, with these equivalent mutants and without a new build."""
        self.write("tb/mutation/equivalent.json", json.dumps(equivalent))
        self.addCleanup(self.write, "tb/mutation/equivalent.json", "[]")
        return self.mutate("--no-build")

    def verdict(self, original, replacement):
        found = [one for one in self.first_results if one["original"] == original and one["replacement"] == replacement]
        self.assertEqual(len(found), 1, (original, replacement, self.first.stdout))
        return found[0]

    def test_mutant_that_a_test_notices_is_killed(self):
        killed = self.verdict("value < limit_", "!(value < limit_)")
        self.assertEqual((killed["verdict"], killed["tests"], killed["kind"]), ("killed", ["rtl: gate"], "rtl"))
        self.assertEqual((killed["file"], killed["line"]), (FILE, 4))
        self.assertEqual(self.verdict("return value + 1;", "return value + 2;")["verdict"], "killed")

    def test_written_mutant_is_killed(self):
        killed = self.verdict("++steps_; return value + 1;", "return value + 1;")
        self.assertEqual((killed["verdict"], killed["operator"]), ("killed", "a step too few"))

    def test_mutant_that_hangs_is_killed(self):
        killed = self.verdict("value = step(value);", ";")
        self.assertEqual((killed["verdict"], killed["tests"]), ("killed", ["rtl: gate (hangs)"]))

    def test_mutant_that_no_test_notices_survives(self):
        self.assertEqual(self.first.returncode, 1, self.first.stdout)
        survived = self.verdict("value < limit_", "value <= limit_")
        self.assertEqual((survived["verdict"], survived["reached_by_tests"]), ("survived", 1))
        self.assertRegex(self.first.stdout, r"survived 1 tests: \d+: model/rtl/gate.cpp:4: relational: value < limit_")
        unreached = self.verdict("return limit_ - 1;", "return limit_ + 1;")
        self.assertEqual((unreached["verdict"], unreached["reached_by_tests"]), ("survived", 0))

    def test_mutant_that_does_not_compile_is_discarded(self):
        self.assertEqual(self.verdict('return "gate";', "return NoSuchName;")["verdict"], "discarded")
        self.assertRegex(self.first.stdout, r", [1-9]\d* discarded; ")

    def test_mutant_that_asks_for_a_template_that_does_not_compile_is_discarded(self):
        self.assertEqual(self.verdict("return size_of<2>();", "return size_of<3>();")["verdict"], "discarded")

    def test_all_survivors_known_to_be_equivalent_is_success(self):
        survivors = [{key: one[key] for key in ("file", "original", "replacement", "occurrence")} | {"reason": "shown"}
                     for one in self.first_results if one["verdict"] == "survived"]
        self.assertGreaterEqual(len(survivors), 4)
        done = self.again(survivors)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn(f" {len(survivors)} equivalent, 0 survived", done.stdout)

    def test_run_that_was_cut_off_goes_on(self):
        path = self.tree / "build/mutate/results.json"
        before = path.read_text()
        self.addCleanup(path.write_text, before)

        def find(mutants, original, replacement):
            return next(one for one in mutants if (one["original"], one["replacement"]) == (original, replacement))
        # A mutant that would survive is noted as killed, so it is not tried again. One that has met no test yet is
        # tried. One that met the quick tests when the one that kills it was not among them meets it now.
        changed = json.loads(json.dumps({"mutants": self.first_results}))
        find(changed["mutants"], "value < limit_", "value <= limit_").update(verdict="killed", tests=["before the cut"])
        find(changed["mutants"], "return value + 1;", "return value + 2;").update(verdict="survived", tests=[], met="")
        find(changed["mutants"], "value < limit_", "!(value < limit_)").update(verdict="survived", tests=[], ran=[])
        path.write_text(json.dumps(changed))
        self.mutate("--no-build", "--resume")
        after = self.results()
        self.assertEqual(find(after, "value < limit_", "value <= limit_")["tests"], ["before the cut"])
        self.assertEqual(find(after, "return value + 1;", "return value + 2;")["tests"], ["rtl: gate"])
        self.assertEqual(find(after, "value < limit_", "!(value < limit_)")["tests"], ["rtl: gate"])

    def test_equivalent_mutant_that_is_killed_is_reported(self):
        done = self.again([AT_LIMIT, NEGATED])
        self.assertEqual(done.returncode, 1)
        self.assertIn("equivalent.json: killed by rtl: gate", done.stdout)
        verdicts = {one["replacement"]: one["verdict"] for one in self.results() if one["original"] == "value < limit_"}
        self.assertEqual((verdicts["value <= limit_"], verdicts["!(value < limit_)"]), ("equivalent", "killed"))

    def test_equivalents_of_other_files_do_not_matter_when_some_are_asked_for(self):
        written = {key: WRITTEN[0][key] for key in ("file", "original", "replacement")}
        self.write("tb/mutation/equivalent.json", json.dumps([AT_LIMIT | {"reason": ""},
                                                              written | {"occurrence": WRITTEN[0]["what"], "reason": ""}]))
        self.addCleanup(self.write, "tb/mutation/equivalent.json", "[]")
        self.assertEqual(self.mutate("--list", "model/rtl/none").stdout, "")

    def test_equivalent_mutant_that_no_longer_exists_is_reported(self):
        done = self.again(UNREACHED)
        self.assertEqual(done.returncode, 1)
        self.assertIn("equivalent.json: no such mutant any more: model/rtl/gate.cpp: return value;", done.stdout)
        self.assertNotIn("any more: model/rtl/gate.cpp: return limit_", done.stdout)

    def test_tables_are_written_between_their_marks(self):
        text = (self.tree / "table.md").read_text()
        self.assertTrue(text.startswith("before\n<!-- mutants by block -->\n| block | mutants |"), text)
        self.assertRegex(text, r"\| `rtl/gate` \| \d+ \| \d+ \| 0 \| \d+ \|")
        self.assertIn("<!-- end of mutants by block -->\nafter\n", text)
        self.assertIn("| operator | mutants | to choose from |", text)
        self.assertRegex(text, r"\| relational \| 2 \| 2 \|")
        self.assertIn("| written by hand | 1 | 2 |", text)

    def test_list_is_the_same_each_time_and_smaller_if_asked(self):
        lists = {self.mutate("--list", "--count", "5", "--seed", "7").stdout for _ in range(2)}
        self.assertEqual(len(lists), 1)
        self.assertEqual(len(lists.pop().splitlines()), 5 + len(WRITTEN))
        self.assertEqual(self.mutate("--list", "model/rtl/none").stdout, "")

    def test_several_seeds_choose_their_mutants_for_one_run(self):
        def listed(*seeds):
            options = [word for seed in seeds for word in ("--seed", str(seed))]
            # Without the numbers, which are positions in the list.
            return {line.split(None, 1)[1] for line in self.mutate("--list", "--count", "5", *options).stdout.splitlines()}
        self.assertNotEqual(listed(1), listed(2))
        self.assertEqual(listed(1, 2), listed(1) | listed(2))

    def test_one_mutant_is_shown_as_a_patch(self):
        number = self.verdict("value < limit_", "value <= limit_")["number"]
        done = self.mutate("--no-build", "--only", str(number))
        self.assertIn("-    if (value < limit_) {\n+    if (value <= limit_) {\n", done.stdout)
        self.assertRegex(done.stdout, rf"survived 1 tests: {number}: ")
        self.assertEqual(done.returncode, 1)

    def test_judges_are_compared(self):
        path = self.tree / "build/mutate/results.json"
        self.addCleanup(path.write_text, path.read_text())
        killed = sum(one["verdict"] == "killed" for one in self.first_results)
        done = self.mutate("--no-build", "--judge", "gate=gate$", "--judge", "units=^unit: ")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stdout, rf"\| `rtl/gate` \| \d+ \| {killed} \| 0 \|")
        self.assertRegex(done.stdout, r"killed by gate \(rtl: gate\), not by units: \d+: model/rtl/gate.cpp:4: ")
        self.assertIn({"gate": "rtl: gate"}, [one["killers"] for one in self.results()])
        done = self.mutate("--no-build", "--judge", "units=^unit: ", "--judge", "gate=gate$")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("0 mutants that units kills are missed", done.stdout)

    def test_source_that_has_changed_is_read_again(self):
        before = self.mutate("--list").stdout
        self.assertIn("value < limit_  ->  value <= limit_", before)
        self.addCleanup(self.write, FILE, SOURCE)
        self.write(FILE, SOURCE.replace("value < limit_", "limit_ > value"))
        after = self.mutate("--list").stdout
        self.assertNotIn("value < limit_  ->", after)
        self.assertIn("limit_ > value  ->  limit_ >= value", after)
        self.write(FILE, SOURCE.replace("value < limit_", "value < no_limit"))
        refused = self.mutate("--list")
        self.assertEqual(refused.returncode, 3)
        self.assertIn("gate.cpp cannot be read", refused.stdout)

    def test_source_is_not_changed(self):
        self.assertEqual((self.tree / FILE).read_text(), SOURCE)
        copy = (self.tree / "build/mutate/source" / FILE).read_text()
        self.assertTrue(re.search(r"mutation::active\(\d+\)", copy))

    def test_bad_arguments_are_refused(self):
        for arguments in [("--count", "-1"), ("--only", "0"), ("--only", "-1"), ("--only", "model/none", "--no-build"), ("--only", "70000", "--no-build"), ("--colour",),
                          ("--judge", "all"), ("--judge", "all=(")]:
            self.assertEqual(self.mutate(*arguments).returncode, 2, arguments)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
