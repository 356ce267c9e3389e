"""Tests where scripts/mutate finds something to change in C++, and where it must not.

usage: sites_test.py SCRIPTS
"""

import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, sys.argv[1])

from lib.compile_commands import arguments_of  # noqa: E402
from mutation import mutants, sites, switches  # noqa: E402

TREE = pathlib.Path(__file__).resolve().parents[2]

PROLOGUE = """
#define STEP(member) { ++member; member *= 2; }
#define LIMIT 17
#define ABOVE(a, b) (a > b)
constexpr int kWidth = 4;
constexpr char kText[] = "text";
struct Sizes { static constexpr int kHeight = 3; int size() const; int operator[](int) const; bool empty() const; };
struct Stream {};
Stream& operator<<(Stream&, int);
int max(int, int);
int run(int);
template <typename F> void each(F) {}
"""


class Sites(unittest.TestCase):
    def read(self, text, *arguments):
        """Each site's text, its form and what it is changed to, in a source after the prologue."""
        with tempfile.TemporaryDirectory() as directory:
            header, source = pathlib.Path(directory) / "prologue.h", pathlib.Path(directory) / "source.cpp"
            header.write_text(PROLOGUE)
            source.write_text(text)
            unit = sites.parse(str(source), ["-std=c++17", "-include", str(header), *arguments])
            found = sites.sites_of(unit, str(source))
        made = {}
        for candidate in mutants.candidates_of("source.cpp", text, found):
            made.setdefault((candidate.key.original, candidate.edit.form), []).append(
                (candidate.operator, candidate.key.replacement))
        return made

    def changes(self, statement):
        """What a statement of a function is changed to, by operator."""
        made = self.read(f"int f(int a, int b, int* p, Sizes& s, Stream& out) {{ {statement} return 0; }}")
        return {text: operator for (_, _), changes in made.items() for operator, text in changes
                if text not in (";", "return 1;", "return 0;")}

    def test_binary_operators(self):
        for old, new, kind in [("<", "<=", "relational"), ("<=", "<", "relational"), (">", ">=", "relational"),
                               (">=", ">", "relational"), ("==", "!=", "relational"), ("!=", "==", "relational"),
                               ("&&", "||", "logical"), ("||", "&&", "logical"), ("+", "-", "arithmetic"),
                               ("-", "+", "arithmetic"), ("*", "/", "arithmetic"), ("/", "*", "arithmetic"),
                               ("%", "/", "arithmetic"), ("<<", ">>", "arithmetic"), (">>", "<<", "arithmetic"),
                               ("&", "|", "arithmetic"), ("|", "&", "arithmetic"), ("^", "|", "arithmetic")]:
            self.assertEqual(self.changes(f"a = a {old} b;"), {f"a = a {new} b;": kind})
            self.assertEqual(self.changes(f"a = a{old}b;"), {f"a = a{new}b;": kind})  # whatever its spaces
        self.assertEqual(self.changes("a += b;"), {"a -= b;": "arithmetic"})
        self.assertEqual(self.changes("a -= b;"), {"a += b;": "arithmetic"})

    def test_other_operators(self):
        self.assertEqual(self.changes("++a;"), {"--a;": "step"})
        self.assertEqual(self.changes("b = a--;"), {"b = a++;": "step"})
        self.assertEqual(self.changes("a = !b;"), {"a = b;": "negation"})
        self.assertEqual(self.changes("a = p[b];"), {"a = p[b + 1];": "index"})
        self.assertEqual(self.changes("a = s[b];"), {"a = s[b + 1];": "index"})
        self.assertEqual(self.changes("a = 7;"), {"a = 8;": "constant", "a = 6;": "constant"})
        self.assertEqual(self.changes("a = true;"), {"a = false;": "constant"})
        self.assertEqual(self.changes("a = kWidth;"), {"a = (kWidth + 1);": "constant"})
        self.assertEqual(self.changes("a = Sizes::kHeight;"), {"a = (Sizes::kHeight + 1);": "constant"})
        self.assertEqual(self.changes("a = max(a, b);"), {"a = min(a, b);": "min/max"})
        self.assertEqual(self.changes("a = s.empty();"), {})

    def test_signs_that_are_no_operators_stay(self):
        self.assertEqual(self.changes("a = -b; p = &a; a = *p; int&& r = static_cast<int&&>(a);"), {})
        self.assertEqual(self.changes("out << b;"), {})  # output
        self.assertEqual(self.changes('const char* text = "1 + 1 < 2"; text = a ? "3" : "4";'), {})
        self.assertEqual(self.changes("p = new int[b];"), {})
        self.assertEqual(self.changes("const char* text = kText;"), {})

    def test_numbers(self):
        self.assertEqual(set(self.changes("run(7);")), {"run(8);", "run(6);"})
        self.assertEqual(set(self.changes("run(0);")), {"run(1);"})
        self.assertEqual(self.changes("run(0600);"), {})  # a base that the change would leave

    def test_forms(self):
        made = self.read("""
            int f(int a) {
                const int b = a + 1;
                if (a < b) { run(a); }
                while (a > 2) run(b);
                for (int i = 0; i < b; ++i) continue;
                do { --a; } while (a != 0);
                if (const int c = a; c == b) throw a;
                if (const int d = run(a * b)) throw d;
                return b - 1;
            }""")
        self.assertEqual(sorted(made), sorted([
            ("a + 1", "value"), ("a < b", "condition"), ("run(a);", "statement"), ("a > 2", "condition"),
            ("run(b);", "statement"), ("i < b", "condition"), ("continue;", "statement"), ("--a;", "statement"),
            ("a != 0", "condition"), ("c == b", "condition"), ("run(a * b)", "value"),
            ("return b - 1;", "statement")]))
        self.assertIn(("negated condition", "!(a < b)"), made[("a < b", "condition")])
        self.assertIn(("left out", ";"), made[("run(a);", "statement")])
        self.assertNotIn("left out", dict(made[("return b - 1;", "statement")]))

    def test_what_the_compiler_computes_is_left_alone(self):
        made = self.read("""
            template <int N> int f(int a) {
                static_assert(N > 1);
                static int calls = 1 + 1;
                constexpr int limit = N + 1;
                if constexpr (N > 2) { run(1); }
                switch (a) {
                    case 1 + 1: run(2); break;
                    default: break;
                }
                return limit;
            }
            int g() { return f<2 + 1>(0); }""")
        texts = {original for original, _ in made}
        self.assertEqual(texts, {"run(1);", "run(2);", "break;", "return f<2 + 1>(0);"})

    def test_macro_call_is_left_out_or_negated_but_not_changed(self):
        made = self.read("""
            struct Block { int steps = 0; void edge(int a) { STEP(steps); a = LIMIT + a; if (ABOVE(a, 3)) run(a); } };
            """)
        self.assertEqual(made[("STEP(steps);", "statement")], [("left out", ";")])
        self.assertEqual(made[("a = LIMIT + a;", "statement")], [("arithmetic", "a = LIMIT - a;"), ("left out", ";")])
        self.assertEqual(made[("ABOVE(a, 3)", "condition")], [("negated condition", "!(ABOVE(a, 3))")])

    def test_function_that_a_macro_defines_has_no_sites(self):
        self.assertEqual(self.read("#define MAKE(name) int name() { return 1 + 1; }\nMAKE(made)\n"), {})

    def test_branch_that_is_not_compiled_has_no_sites(self):
        text = "int f(int a) {\n#ifdef OTHER\n    return a + 1;\n#else\n    return a - 1;\n#endif\n}\n"
        self.assertEqual({original for original, _ in self.read(text)}, {"return a - 1;"})
        self.assertEqual({original for original, _ in self.read(text, "-DOTHER")}, {"return a + 1;"})

    def test_templates_and_members_are_read(self):
        made = self.read("""
            template <typename T> struct Least { T least; bool take(T one) { return one < least; } };
            namespace { template <typename T> T twice(T one) { return one + one; } }
            struct Made { int a; Made(int b) : a(b + 1) { a -= b; } ~Made() { a = 0; } operator int() { return a / 2; } };
            """)
        texts = {original for original, _ in made}
        self.assertEqual(texts, {"return one < least;", "return one + one;", "a -= b;", "a = 0;", "return a / 2;"})

    def test_of_a_lambda_the_body_is_read(self):
        made = self.read("void f(int a) { each([&](int b) { a += b; }); const auto g = [&] { return a > 1; }; g(); }")
        self.assertEqual({original for original, _ in made}, {"a += b;", "return a > 1;", "g();"})

    def test_functions_that_only_report_are_skipped(self):
        text = "void trace(int a) { run(a + 1); } Stream& operator<<(Stream& s, char) { run(2); return s; }"
        self.assertEqual(self.read(text), {})

    def test_source_that_does_not_compile_is_reported(self):
        with self.assertRaisesRegex(sites.ParseError, "NoSuchName"):
            self.read("int f() { return NoSuchName; }")

    def test_arguments_that_matter_are_taken_from_a_compile_command(self):
        command = "/usr/bin/ccache /usr/bin/c++ -DA=1 -I/x/model -isystem /y -O1 -w -std=c++17 -o a.o -c /x/a.cpp"
        self.assertEqual(arguments_of(command), ["-DA=1", "-I/x/model", "-isystem", "/y", "-std=c++17"])


@unittest.skipIf((TREE / "model" / switches.HEADER).exists(), "the copy with mutants in it")
class Lists(unittest.TestCase):
    """The lists of mutants quote text of the model, which may change without them."""

    def entries(self, name):
        for entry in json.loads((TREE / "tb/mutation" / name).read_text()):
            yield entry, (TREE / entry["file"]).read_text()

    def test_every_mutant_written_by_hand_fits_its_file(self):
        for entry, source in self.entries("written.json"):
            with self.subTest(f"{entry['file']}: {entry['what']}"):
                mutants.written_mutant(entry, source)
                for edit in entry.get("edits", [entry]):
                    # What is switched is an expression or whole statements. A switch would hide a declaration.
                    for text in (edit["original"], edit["replacement"]):
                        self.assertEqual(text.count("{"), text.count("}"))
                    if edit["original"].rstrip().endswith((";", "}")):
                        self.assertNotRegex(edit["original"], r"^\s*(const|constexpr|auto)\b")

    def test_what_every_equivalent_mutant_changes_is_there(self):
        for entry, source in self.entries("equivalent.json"):
            with self.subTest(f"{entry['file']}: {entry['original']}"):
                self.assertIn("".join(entry["original"].split()), "".join(source.split()))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
