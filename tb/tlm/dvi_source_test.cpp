#include "tlm/dvi_source.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "formats/control_scanline.h"
#include "socket_bench.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_source_test {
namespace {

TEST_CASE("dvi source: a frame comes with its control scanline, a word a pixel, and no word more") {
    constexpr int kWidth = 24;
    Scenario scenario = small_scenario(kWidth, 4);
    add_renderer(scenario, renderer_of({noise_image(1, kWidth, 4)}, {segment_row({kWidth, 4})}));
    sc_core::sc_signal<bool> request{"request", true};
    tlm::DviSource dut("dut", scenario, 0, 0);
    Target<tlm::DviFrame> decoder("decoder");
    dut.link_socket.bind(decoder.socket);
    dut.pair_request_i(request);
    std::vector<std::vector<std::uint32_t>> scanlines;
    decoder.on_transport = [&scanlines](::tlm::tlm_generic_payload& payload) {
        scanlines.push_back(tlm::content_of<tlm::DviFrame>(payload).control);
    };
    sc_core::sc_start(1, sc_core::SC_MS);
    REQUIRE(scanlines.size() == 2);  // a pair
    for (const std::vector<std::uint32_t>& words : scanlines) CHECK(words.size() == std::size_t{kWidth});
    CHECK(decode_control_scanline(scanlines[0]).content.kind == FrameKind::kColour);
    CHECK(decode_control_scanline(scanlines[1]).content.kind == FrameKind::kDepth);
}

TEST_CASE("dvi source: in lockstep a pair starts at the clock that reads the request, one after its rise") {
    constexpr int kWidth = 24;
    Scenario scenario = small_scenario(kWidth, 4);
    scenario.pacing = Pacing::kLockstep;
    add_renderer(scenario, renderer_of({noise_image(1, kWidth, 4)}, {segment_row({kWidth, 4})}));
    // In the very clock that ends the first sync, and later.
    constexpr std::int64_t kSyncEnd = 8 * (kWidth + 80);
    constexpr std::array<std::int64_t, 3> kRises{kSyncEnd, kSyncEnd + 1, 5'000};
    struct Link {
        sc_core::sc_signal<bool> request;
        tlm::DviSource dut;
        Target<tlm::DviFrame> decoder;
        std::vector<std::int64_t> first_edges;
        Link(const Scenario& scenario, const std::string& number)
            : request(("request_" + number).c_str()),
              dut(("dut_" + number).c_str(), scenario, 0, 0),
              decoder(("decoder_" + number).c_str()) {
            dut.link_socket.bind(decoder.socket);
            dut.pair_request_i(request);
            decoder.on_transport = [this](::tlm::tlm_generic_payload& payload) {
                first_edges.push_back(tlm::content_of<tlm::DviFrame>(payload).first_edge);
            };
        }
    };
    std::vector<std::unique_ptr<Link>> links;
    for (const std::int64_t rise : kRises) {
        links.push_back(std::make_unique<Link>(scenario, std::to_string(rise)));
    }
    const tlm::ClockDomain clock(clock_period_picoseconds(scenario.clocks.dvi_in_mhz));
    for (std::size_t i = 0; i < kRises.size(); ++i) {
        sc_core::sc_start(clock.until(kRises[i]));
        CHECK(links[i]->first_edges.empty());
        links[i]->request.write(true);
    }
    sc_core::sc_start(clock.until(kRises.back() + 10));
    for (std::size_t i = 0; i < kRises.size(); ++i) {
        INFO("request at clock " << kRises[i]);
        REQUIRE_FALSE(links[i]->first_edges.empty());
        CHECK(links[i]->first_edges.front() == kRises[i] + 1);
    }
    CHECK(links.back()->first_edges.size() == 1);
}

}  // namespace
}  // namespace metabuffer::test::dvi_source_test
