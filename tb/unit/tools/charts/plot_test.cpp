#include "tools/charts/plot.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <functional>
#include <string>

#include "host/errors.h"
#include "host/filter_process.h"
#include "sample_results.h"

using namespace metabuffer;
using namespace metabuffer::test;
using Catch::Matchers::Contains;
using charts::ChartKind;
using charts::plot_svg;
using charts::PlotRequest;

namespace {

PlotRequest request_of(ChartKind chart) {
    PlotRequest request;
    request.chart = chart;
    return request;
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t result = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
        ++result;
    return result;
}

/// Elements inside the group of a mark, which Vega calls by its kind and name.
std::size_t marks(const std::string& svg, const std::string& kind, const std::string& name) {
    std::size_t result = 0;
    const std::string group = "<g class=\"mark-" + kind + " role-mark " + name + "\"";
    for (std::size_t at = svg.find(group); at != std::string::npos; at = svg.find(group, at + 1)) {
        const std::size_t end = svg.find("</g>", at);
        result += count(svg.substr(at, end - at), "<path");
    }
    return result;
}

/// While it lives, no other program is found.
class NoPrograms {
  public:
    explicit NoPrograms(const ScratchDirectory& empty) {
        if (const char* const path = std::getenv("PATH")) path_ = path;
        setenv("PATH", empty.path().c_str(), 1);
    }
    NoPrograms(const NoPrograms&) = delete;
    NoPrograms& operator=(const NoPrograms&) = delete;
    ~NoPrograms() { setenv("PATH", path_.c_str(), 1); }

  private:
    std::string path_;
};

}  // namespace

TEST_CASE("A program gets all of its input and gives all of its output, or is reported in one line",
          "[charts]") {
    std::string input;
    for (int n = 0; n < 300'000; ++n) input += std::to_string(n) + "\n";
    CHECK(filtered({{"cat"}, "coreutils"}, input) == input);
    CHECK(filtered({{"true"}, "coreutils"}, input).empty());  // though it reads nothing
    CHECK(filtered({{"cat"}, "coreutils"}, "").empty());
    CHECK_THROWS_WITH(filtered({{"false"}, "coreutils"}, "text"), "metabuffer: false: failed");
    CHECK_THROWS_WITH(filtered({{"cat", "/nonexistent/file"}, "coreutils"}, ""),
                      Contains("cat: failed: ") && Contains("/nonexistent/file") && !Contains("\n"));
    const ScratchDirectory scratch;
    const auto file = sample_results(scratch);
    const ScratchDirectory empty;
    const NoPrograms none(empty);
    CHECK_THROWS_AS(plot_svg({file}, {}), OutputError);
    CHECK_THROWS_WITH(plot_svg({file}, {}),
                      Contains("node") && Contains("package nodejs") && !Contains("\n"));
    CHECK_THROWS_WITH(charts::png_of("<svg/>"), Contains("rsvg-convert") && Contains("librsvg2-bin"));
}

TEST_CASE("Every chart has a mark for every point that has a value", "[charts]") {
    const ScratchDirectory scratch;
    const auto file = sample_results(scratch);

    const std::string lines = plot_svg({file}, {});
    CHECK(marks(lines, "symbol", "points") == 3);
    CHECK(marks(lines, "symbol", "lost") == 1);
    CHECK(count(lines, "class=\"mark-line ") == 2);  // a policy each
    CHECK_THAT(lines, Contains(">bus.width_bits</text>"));
    CHECK_THAT(lines, Contains(">frames per second</text>"));
    CHECK_THAT(lines, Contains(">bus.arbitration</text>"));
    CHECK_THAT(lines, Contains("no value (1 point)"));

    const std::string map = plot_svg({file}, request_of(ChartKind::kHeatmap));
    CHECK(marks(map, "rect", "cells") == 4);
    CHECK_THAT(map, Contains(">700</text>"));
    CHECK(marks(map, "symbol", "corners") == 2);  // the two that starve

    const std::string front = plot_svg({file}, request_of(ChartKind::kPareto));
    CHECK(marks(front, "symbol", "points") == 3);
    CHECK(marks(front, "line", "front") == 1);
    CHECK_THAT(front,
               Contains(">whole pictures</text>") && Contains(">not whole: starved or rejected</text>"));

    const std::string policy = plot_svg({file}, request_of(ChartKind::kPolicy));
    CHECK(marks(policy, "rect", "bars") == 4);  // two policies by two figures
    CHECK_THAT(policy, Contains(">recovered slots</text>") && Contains(">50%</text>"));

    PlotRequest histogram = request_of(ChartKind::kHistogram);
    histogram.references = {{500.0, "asked for"}};
    const std::string bins = plot_svg({file}, histogram);
    CHECK(marks(bins, "rect", "bins") == 2);
    CHECK_THAT(bins, Contains(">asked for</text>"));

    CHECK(marks(plot_svg({file}, request_of(ChartKind::kScatter)), "symbol", "points") == 3);
}

TEST_CASE("Axes that go together count as one", "[charts]") {
    const ScratchDirectory scratch;
    std::vector<exploration::RunRecord> runs;
    for (const char* pixels : {"8", "16", "32"}) {
        for (const char* policy : {"irsa", "edf"}) {
            runs.push_back(done_run({{"bus.burst_pixels", pixels},
                                     {"composer.ready_space_pixels", pixels},
                                     {"bus.arbitration", policy}},
                                    {{"frames_per_second", 100.0}}));
        }
    }
    const auto file =
        write_results(scratch, {"bus.burst_pixels", "composer.ready_space_pixels", "bus.arbitration"}, runs);
    const std::string lines = plot_svg({file}, {});
    CHECK(count(lines, "class=\"mark-line ") == 2);  // a policy each, not a point each
    PlotRequest over_twin;
    over_twin.x = "composer.ready_space_pixels";
    CHECK(count(plot_svg({file}, over_twin), "class=\"mark-line ") == 2);
    const std::string map = plot_svg({file}, request_of(ChartKind::kHeatmap));
    CHECK(marks(map, "rect", "cells") == 6);
    CHECK_THAT(map, Contains(">bus.arbitration</text>") && !Contains(">composer.ready_space_pixels</text>"));
}

TEST_CASE("The front leaves out what costs as much and gives less", "[charts]") {
    const ScratchDirectory scratch;
    struct Machine {
        std::int64_t bits;
        double rate;
        std::int64_t starved;
    };
    // The one with the highest rate starves, so it is not on the front. Of two at the same cost the faster one is.
    std::vector<exploration::RunRecord> runs;
    for (const Machine& machine : {Machine{100, 10.0, 0}, Machine{200, 30.0, 0}, Machine{200, 20.0, 0},
                                   Machine{300, 25.0, 0}, Machine{400, 40.0, 0}, Machine{150, 90.0, 5}}) {
        runs.push_back(done_run({{"bus.width_bits", std::to_string(runs.size() + 1)}},
                                {{"cost", machine.bits},
                                 {"frames_per_second", machine.rate},
                                 {"starved_pixels", machine.starved}}));
    }
    const auto file = write_results(scratch, {"bus.width_bits"}, runs);
    const std::string svg = plot_svg({file}, request_of(ChartKind::kPareto));
    CHECK(marks(svg, "symbol", "points") == 6);
    // Steps: each of the three on the front adds a corner to the path after the first.
    const std::size_t line = svg.find("<g class=\"mark-line role-mark front\"");
    REQUIRE(line != std::string::npos);
    const std::string path = svg.substr(svg.find(" d=\"", line), 400);
    CHECK(count(path.substr(0, path.find('"', 5)), "L") == 4);
    CHECK(count(svg, "stroke-width=\"1.5\"") == 3);
}

TEST_CASE("Points on the front have names, and a colour is drawn where it is asked for", "[charts]") {
    const ScratchDirectory scratch;
    const auto file = sample_results(scratch);
    const std::string usual = plot_svg({file}, request_of(ChartKind::kPareto));
    CHECK(count(usual, "class=\"mark-text role-mark names\"") == 1);
    CHECK_THAT(usual, Contains(">64, irsa</text>"));
    PlotRequest request = request_of(ChartKind::kPareto);
    request.label = "'width ' || bus.width_bits";
    request.colour = "bus.arbitration";
    const std::string svg = plot_svg({file}, request);
    CHECK_THAT(svg, Contains(">width 64</text>") && !Contains(">64, irsa</text>"));
    CHECK_THAT(svg,
               Contains(">irsa</text>") && Contains(">edf</text>") && Contains(">bus.arbitration</text>"));
    CHECK(svg != usual);
}

TEST_CASE("A heat map shows whole numbers to the last digit", "[charts]") {
    const ScratchDirectory scratch;
    const auto run = [](const char* width, std::int64_t cycles) {
        return done_run({{"bus.width_bits", width}, {"bus.burst_pixels", "8"}}, {{"core_cycles", cycles}});
    };
    const auto file = write_results(scratch, {"bus.width_bits", "bus.burst_pixels"},
                                    {run("32", 37'792), run("64", 56'521'604)});
    PlotRequest request = request_of(ChartKind::kHeatmap);
    request.x = "bus.width_bits";
    request.y = {"bus.burst_pixels"};
    request.colour = "core_cycles";
    const std::string svg = plot_svg({file}, request);
    CHECK_THAT(svg, Contains(">37,792</text>") && Contains(">56,521,604</text>"));
}

TEST_CASE("A heat map marks what is not whole, however small its fields are", "[charts]") {
    const ScratchDirectory scratch;
    std::vector<exploration::RunRecord> runs;
    for (int pixels = 1; pixels <= 120; ++pixels) {
        runs.push_back(
            done_run({{"composer.buffer_pixels", std::to_string(pixels)}, {"bus.burst_pixels", "8"}},
                     {{"rejected_rows", std::int64_t{pixels <= 3}}}));
    }
    PlotRequest request = request_of(ChartKind::kHeatmap);
    request.x = "composer.buffer_pixels";
    request.y = {"bus.burst_pixels"};
    request.width_pixels = 300;
    const std::string svg =
        plot_svg({write_results(scratch, {"composer.buffer_pixels", "bus.burst_pixels"}, runs)}, request);
    CHECK(marks(svg, "symbol", "corners") == 3);
    CHECK_THAT(svg, Contains("corner: not whole"));
}

TEST_CASE("What cannot be drawn, and an option without use, is reported", "[charts]") {
    const ScratchDirectory scratch;
    const auto file = sample_results(scratch);
    const auto error = [&file](ChartKind chart, const std::function<void(PlotRequest&)>& ask) {
        PlotRequest request = request_of(chart);
        ask(request);
        std::string message;
        try {
            plot_svg({file}, request);
        } catch (const InputError& refused) {
            message = refused.what();
        }
        return message;
    };
    CHECK(error(ChartKind::kHeatmap, [](PlotRequest& r) { r.log_x = true; }) ==
          "--log-x: heatmap has its values side by side along that axis; leave it out");
    CHECK(error(ChartKind::kPolicy, [](PlotRequest& r) { r.log_x = true; }).rfind("--log-x: policy has", 0) ==
          0);
    CHECK(error(ChartKind::kHeatmap, [](PlotRequest& r) { r.log_y = true; }).rfind("--log-y: heatmap", 0) ==
          0);
    CHECK(error(ChartKind::kHeatmap, [](PlotRequest& r) {
              r.references = {{1.0, ""}};
          }) == "--reference: heatmap has no axis with the figure; leave it out");
    CHECK(error(ChartKind::kHeatmap, [](PlotRequest& r) {
              r.y = {"bus.arbitration", "starved_pixels"};
          }) == "--y: heatmap has one axis there and takes one expression; leave it out");
    CHECK(error(ChartKind::kHistogram, [](PlotRequest& r) { r.y = {"starved_pixels"}; }) ==
          "--y: histogram counts points along that axis; leave it out");
    CHECK(error(ChartKind::kLines, [](PlotRequest& r) { r.label = "point"; }) ==
          "--label: lines has no front whose points to name; leave it out");
    CHECK(error(ChartKind::kLines, [](PlotRequest& r) { r.facet_title = "of"; }) ==
          "--facet-title: lines has no panels without --facet; leave it out");
    CHECK(error(ChartKind::kScatter, [](PlotRequest& r) { r.log_x = r.log_y = true; }).empty());
    PlotRequest request;
    request.y = {"starved_pixel"};
    CHECK_THROWS_WITH(plot_svg({file}, request), Contains("--y") && Contains("starved_pixels"));
    request = {};
    request.colour = "bus.arbitration +";
    CHECK_THROWS_WITH(plot_svg({file}, request), Contains("--colour"));
    request = {};
    request.condition = "bus.width_bits > 1000";
    CHECK_THROWS_WITH(plot_svg({file}, request), Contains("--where") && Contains("results.db"));
    request = request_of(ChartKind::kHeatmap);
    request.condition = "bus.width_bits = 32";
    CHECK_THROWS_WITH(plot_svg({file}, request), Contains("--y") && Contains("axis"));
    CHECK_THROWS_WITH(charts::chart_of("pie"), Contains("--chart") && Contains("histogram"));
}

TEST_CASE("Without a frame rate the front says what it needs, and other charts take clocks a frame",
          "[charts]") {
    const ScratchDirectory scratch;
    const auto run = [](const char* width) {
        return done_run({{"bus.width_bits", width}},
                        {{"frames_per_second", exploration::Value()}, {"frame_cycles", 1000.0}});
    };
    const auto file = write_results(scratch, {"bus.width_bits"}, {run("32"), run("64")});
    CHECK_THROWS_WITH(plot_svg({file}, request_of(ChartKind::kPareto)),
                      Contains("no point has a frame rate, for which a run needs three frames"));
    CHECK_THAT(plot_svg({file}, {}), Contains(">frame cycles"));
    CHECK_THAT(plot_svg({file}, request_of(ChartKind::kScatter)), Contains(">frame cycles"));
}

TEST_CASE("Expressions and titles and panels are as asked for", "[charts]") {
    const ScratchDirectory scratch;
    const auto file = sample_results(scratch);
    PlotRequest request;
    request.x = "bus.width_bits / 8";
    request.y = {"starved_pixels", "late_pixels"};
    request.facet = "bus.arbitration";
    request.condition = "status = 'done'";
    request.title = "A <b>bold</b> & \"quoted\" title";
    request.x_title = "bytes </text><script>";
    const std::string svg = plot_svg({file}, request);
    CHECK_THAT(svg, Contains("A &lt;b&gt;bold&lt;/b&gt; &amp; \"quoted\" title"));
    CHECK_THAT(svg, Contains("bytes &lt;/text&gt;&lt;script&gt;"));
    CHECK_THAT(svg, !Contains("<script"));
    CHECK_THAT(svg, Contains("bus.arbitration irsa") && Contains("bus.arbitration edf"));
    CHECK_THAT(svg, Contains(", starved pixels</text>") && Contains(", late pixels</text>"));
    CHECK(marks(svg, "symbol", "points") == 6);
    CHECK(plot_svg({file}, request) == svg);
    CHECK(scratch.names() == std::vector<std::string>{"results.db"});
}

TEST_CASE("The picture has the size asked for and a PNG twice that", "[charts]") {
    const ScratchDirectory scratch;
    PlotRequest request;
    request.width_pixels = 500;
    request.height_pixels = 300;
    const std::string svg = plot_svg({sample_results(scratch)}, request);
    CHECK_THAT(svg, Contains("width=\"500\" height=\"300\""));
    const std::string png = charts::png_of(svg);
    REQUIRE(png.size() > 24);
    CHECK(png.substr(1, 3) == "PNG");
    CHECK(png.substr(16, 8) ==
          std::string("\0\0\x03\xE8\0\0\x02\x58", 8));  // 1000 by 600, as the header has it
}
