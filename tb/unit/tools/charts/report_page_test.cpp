#include "tools/charts/report_page.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "host/errors.h"
#include "packed_text.h"
#include "sample_results.h"
#include "tools/charts/base64.h"

namespace metabuffer::test::report_page_test {
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using charts::PageOptions;
using charts::report_page;
using nlohmann::json;

namespace {

const std::string kDataBegin = "<script type=\"application/json\" id=\"data\">";
const std::string kScriptEnd = "</script>";

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t result = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
        ++result;
    return result;
}

/// What the page's script reads, as a browser would cut it out.
json data_of(const std::string& page) {
    const std::size_t begin = page.find(kDataBegin);
    REQUIRE(begin != std::string::npos);
    const std::size_t first = begin + kDataBegin.size();
    return json::parse(page.substr(first, page.find(kScriptEnd, first) - first));
}

/// The page without what is inside scripts and styles.
std::string markup_of(std::string page) {
    for (const std::string& name : {std::string("script"), std::string("style")}) {
        std::size_t at = 0;
        while ((at = page.find("<" + name, at)) != std::string::npos) {
            const std::size_t begin = page.find('>', at) + 1;
            const std::size_t end = page.find("</" + name + ">", begin);
            REQUIRE(end != std::string::npos);
            page.erase(begin, end - begin);
            at = begin;
        }
    }
    return page;
}

/// Empty if every element that is opened is closed in turn.
std::string nesting_error(const std::string& markup) {
    const std::set<std::string> without_end{"meta", "link", "br", "img", "input"};
    const std::regex tag("<(/?)([a-z][a-z0-9]*)([^<>]*)>|<!--[^]*?-->|<!DOCTYPE html>|<");
    std::vector<std::string> open;
    for (std::sregex_iterator match(markup.begin(), markup.end(), tag), end; match != end; ++match) {
        const std::string name = (*match)[2];
        if ((*match)[0] == "<") return "a stray <";
        if (name.empty() || without_end.count(name) != 0) continue;
        if ((*match)[1].length() == 0) {
            open.push_back(name);
        } else if (open.empty() || open.back() != name) {
            return "</" + name + "> does not close " + (open.empty() ? "anything" : open.back());
        } else {
            open.pop_back();
        }
    }
    return open.empty() ? "" : open.back() + " is not closed";
}

/// The index of a figure in the rows of the data.
std::size_t figure_place(const json& data, const std::string& name) {
    for (std::size_t n = 0; n < data["figures"].size(); ++n) {
        if (data["figures"][n]["name"] == name) return n;
    }
    FAIL("no figure " << name);
    return 0;
}

// Of a point's row in the data.
constexpr std::size_t kStatus = 3;
constexpr std::size_t kReason = 4;
constexpr std::size_t kSmallest = 5;
constexpr std::size_t kAxes = 9;
constexpr std::size_t kFigures = 10;

}  // namespace

TEST_CASE("Base64 is what the standard's examples show", "[charts]") {
    CHECK(charts::base64("").empty());
    CHECK(charts::base64("f") == "Zg==");
    CHECK(charts::base64("fo") == "Zm8=");
    CHECK(charts::base64("foo") == "Zm9v");
    CHECK(charts::base64("foobar") == "Zm9vYmFy");
    CHECK(charts::base64(std::string("\xff\x00\xfe", 3)) == "/wD+");
}

TEST_CASE("The page's elements nest, its parts are all filled in, and it refers to nothing outside of itself",
          "[charts]") {
    const ScratchDirectory scratch;
    const std::string page = report_page({sample_results(scratch)}, {});
    CHECK(page.rfind("<!DOCTYPE html>", 0) == 0);
    const std::string markup = markup_of(page);
    CHECK_THAT(nesting_error(markup), Equals(""));
    CHECK_THAT(markup, Contains("<title>sample</title>"));
    CHECK_THAT(markup, Contains("<h1>sample</h1>"));
    for (const char* part : {"@TITLE@", "@STYLE@", "@DATA@", "@VEGA@", "@SCALES@", "@CHARTS@", "@ELEMENTS@",
                             "@PAGE_DATA@", "@PAGE_POINT@", "@PAGE@"}) {
        CHECK_THAT(page, !Contains(part));
    }
    // Data, Vega, scales and charts, what the pages share, and the three parts of the page.
    CHECK(count(markup, "<script") == 8);
    CHECK(count(markup, "</script>") == 8);
    const std::regex reference("\\b(src|href|action|data|poster|srcset)=\"([^\"]*)\"");
    for (std::sregex_iterator match(markup.begin(), markup.end(), reference), end; match != end; ++match) {
        INFO((*match)[0]);
        CHECK((*match)[2].str().rfind("data:", 0) == 0);
    }
    CHECK_THAT(markup, Contains("default-src 'none'"));
    CHECK_THAT(page, !Contains("@import"));
    CHECK_THAT(page, !Contains("sourceMappingURL"));
    // Addresses are names of XML's namespaces only.
    const std::regex address("https?://[^\\s\"'`)]*");
    for (std::sregex_iterator match(page.begin(), page.end(), address), end; match != end; ++match) {
        INFO((*match)[0]);
        CHECK((*match)[0].str().rfind("http://www.w3.org/", 0) == 0);
    }
}

TEST_CASE("Nothing in the results can become markup", "[charts]") {
    const ScratchDirectory scratch;
    const std::string evil = "</script><script>alert(1)</script><!-- \"quotes\" & 'more' \\ @DATA@ \xff";
    const std::string harmless = report_page({sample_results(scratch)}, {});
    PageOptions options;
    options.title = evil;
    const std::string page = report_page({sample_results(scratch, "evil.db", evil, evil)}, options);
    CHECK(count(page, "<script") == count(harmless, "<script"));
    CHECK(count(page, kScriptEnd) == count(harmless, kScriptEnd));
    CHECK(count(page, "<!--") == count(harmless, "<!--"));
    CHECK_THAT(nesting_error(markup_of(page)), Equals(""));
    CHECK_THAT(page, Contains("<h1>&lt;/script&gt;&lt;script&gt;alert(1)"));
    // As data it is all there; what is not UTF-8 is replaced.
    const std::string kept = evil.substr(0, evil.size() - 1) + "\xEF\xBF\xBD";
    const json data = data_of(page);
    CHECK(data["sources"][0]["name"] == kept);
    bool found = false;
    for (const json& point : data["points"]) found = found || point[kReason] == kept;
    CHECK(found);
}

TEST_CASE("A condition chooses the points of the page, and the same results make the same page", "[charts]") {
    const ScratchDirectory scratch;
    const auto file = sample_results(scratch);
    const std::string page = report_page({file}, {});
    CHECK(report_page({file}, {}) == page);
    CHECK(scratch.names() == std::vector<std::string>{"results.db"});
    PageOptions options;
    options.condition = "bus.width_bits = 32";
    const json data = data_of(report_page({sample_results(scratch)}, options));
    CHECK(data["points"].size() == 2);
    CHECK(data["embedded"].size() == 2);
    CHECK(data["condition"] == options.condition);
    options.condition = "bus.widht_bits = 32";
    CHECK_THROWS_WITH(report_page({scratch / "results.db"}, options),
                      Contains("--where") && Contains("bus.widht_bits") && Contains("bus.width_bits"));
}

TEST_CASE("The page holds every point with settings and figures and failures with their reasons",
          "[charts]") {
    const ScratchDirectory scratch;
    const json data = data_of(report_page({sample_results(scratch)}, {}));
    CHECK(data["axes"] == json({"bus.width_bits", "bus.arbitration"}));
    REQUIRE(data["points"].size() == 4);
    std::set<std::string> seen;
    for (const json& point : data["points"]) {
        seen.insert(point[kAxes].dump());
        const bool failed = point[kAxes] == json({64, "edf"});
        CHECK(point[kStatus] == (failed ? "invalid" : "done"));
        CHECK(point[kReason] == (failed ? "no such machine" : ""));
        const json rate = point[kFigures][figure_place(data, "frames_per_second")];
        CHECK(rate == (failed ? json() : point[kAxes][0] == 32 ? json(400.5) : json(900.25)));
    }
    CHECK(seen.size() == 4);
    CHECK(data["simulations"].empty());
}

TEST_CASE("Reports and pictures come back from the page as they were", "[charts]") {
    const ScratchDirectory scratch;
    const std::string report = "{\"scenario\": \"</script> \\u00fc\"}\n" + std::string(5000, ' ');
    const std::string png = std::string("\x89PNG\r\n\x1a\n\0\xff<&", 12);
    exploration::RunRecord run = done_run({{"bus.width_bits", "32"}}, {});
    run.report = report;
    run.pictures = {{1, png}, {2, "second"}};
    const auto file = write_results(scratch, {"bus.width_bits"}, {run});
    const json data = data_of(report_page({file}, {}));
    REQUIRE(data["embedded"].size() == 1);
    const json& embedded = data["embedded"].front();
    CHECK(inflated(from_base64(embedded["report"])) == report);
    REQUIRE(embedded["pictures"].size() == 2);
    CHECK(embedded["pictures"][0][0] == 1);
    CHECK(from_base64(embedded["pictures"][0][1]) == png);
    CHECK(from_base64(embedded["pictures"][1][1]) == "second");
    CHECK(data["left_out"]["reports"] == 0);
    CHECK(data["left_out"]["pictures"] == 0);
}

TEST_CASE("What goes beyond the page's room is left out and counted", "[charts]") {
    const ScratchDirectory scratch;
    std::vector<exploration::RunRecord> runs;
    for (int width = 1; width <= 20; ++width) {
        runs.push_back(done_run({{"bus.width_bits", std::to_string(width)}}, {}));
        runs.back().pictures = {{1, std::string(300, 'p')}};
    }
    const auto file = write_results(scratch, {"bus.width_bits"}, runs);
    PageOptions options;
    options.most_embedded_bytes = 2000;
    const json data = data_of(report_page({file}, options));
    std::size_t reports = 0;
    std::size_t pictures = 0;
    std::size_t bytes = 0;
    for (const json& embedded : data["embedded"]) {
        if (embedded.contains("report")) {
            ++reports;
            bytes += embedded["report"].get<std::string>().size();
        }
        if (embedded.contains("pictures")) {
            ++pictures;
            bytes += embedded["pictures"][0][1].get<std::string>().size();
        }
    }
    CHECK(bytes <= options.most_embedded_bytes);
    CHECK(reports >= 10);
    CHECK(pictures >= 2);
    CHECK(reports + data["left_out"]["reports"].get<std::size_t>() == 20);
    CHECK(pictures + data["left_out"]["pictures"].get<std::size_t>() == 20);
    options.most_embedded_bytes = 0;
    CHECK(data_of(report_page({file}, options))["embedded"].empty());
}

TEST_CASE("Files of different sweeps share a page", "[charts]") {
    const ScratchDirectory scratch;
    {
        exploration::ResultsIdentity identity;
        identity.name = "other";
        // An axis that is called as a figure is, and one that the other file has too.
        identity.keys = {"renderers", "bus.arbitration"};
        identity.search_key = "composer.buffer_pixels";
        identity.goal = "starved_pixels = 0";
        auto database = exploration::ResultsDatabase::open(scratch / "other.db", identity);
        std::int64_t run_id = 0;
        for (const char* pixels : {"8", "16"}) {
            run_id = database.add_run(done_run(
                {{"renderers", "3"}, {"bus.arbitration", "irsa"}, {"composer.buffer_pixels", pixels}}, {}));
        }
        exploration::PointRecord point;
        point.settings = {{"renderers", "3"}, {"bus.arbitration", "irsa"}};
        point.smallest = 16;
        point.monotonic = true;
        point.run = run_id;
        point.runs = 2;
        database.add_point(point);
    }
    const json data = data_of(report_page({sample_results(scratch), scratch / "other.db"}, {}));
    CHECK(data["axes"] == json({"bus.width_bits", "bus.arbitration", "renderers"}));
    REQUIRE(data["points"].size() == 5);
    const json& search = data["points"][4];
    CHECK(search[0] == 1);
    CHECK(search[kSmallest] == 16);
    CHECK(search[kAxes] == json({nullptr, "irsa", 3}));
    CHECK(search[kFigures][figure_place(data, "renderers")] == 1);
    REQUIRE(data["simulations"].size() == 2);
    CHECK(data["simulations"][0][4] == 8);
    CHECK(data["simulations"][1][4] == 16);
    CHECK(data["simulations"][1][5] == json({nullptr, "irsa", 3}));
}

TEST_CASE("A file without points makes a page too", "[charts]") {
    const ScratchDirectory scratch;
    { exploration::ResultsDatabase::open(scratch / "results.db", {}); }
    const json data = data_of(report_page({scratch / "results.db"}, {}));
    CHECK(data["points"].empty());
    CHECK_THROWS_AS(report_page({scratch / "none.db"}, {}), InputError);
}

}  // namespace metabuffer::test::report_page_test
