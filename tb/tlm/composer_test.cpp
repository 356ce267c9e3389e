#include "tlm/composer.h"

#include <catch2/catch.hpp>

#include "socket_bench.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"

namespace metabuffer::test::composer_test {
namespace {

TEST_CASE("composer: pixels that come ahead of the first frame do not change when its column may start") {
    constexpr int kWidth = 8;
    constexpr std::int64_t kPipereadyCycle = 100;
    Scenario scenario = small_scenario(kWidth, 4);
    scenario.composer.on_starvation = StarvationMode::kStall;
    const ViewportRow row = segment_row({kWidth, 4});
    add_renderer(scenario, renderer_of({noise_image(1, kWidth, 4)}, {row}));
    tlm::ColumnTime column(1, std::int64_t{kWidth} * 4, true);
    tlm::ColumnRelays relays;
    tlm::Composer dut("dut", scenario, column, relays, {0, 1, false, nullptr});
    Initiator<tlm::BusTransfer> bus("bus");
    Target<tlm::PipelineFrame> output("output_framebuffer");
    bus.socket.bind(dut.bus_socket);
    dut.pipe_out_socket.bind(output.socket);
    elaborate();
    column.set_pipeready_cycle(kPipereadyCycle);

    tlm::Message<tlm::BusTransfer> transfer;
    transfer->row = &row;
    transfer->table_cycle = 12;
    CHECK(bus.send(transfer.payload()) == ::tlm::TLM_OK_RESPONSE);
    transfer->kind = tlm::BusTransfer::Kind::kBeats;
    transfer->beats = {0, kWidth, 20};
    CHECK(bus.send(transfer.payload()) == ::tlm::TLM_OK_RESPONSE);
    CHECK(transfer->pixels_taken == kWidth);
    // PIPEREADY rises in the one composer, and STARTFRAME a clock later.
    CHECK(column.not_before(0, 0, 0) == kPipereadyCycle + 2);
    CHECK_FALSE(column.started(0));
}

}  // namespace
}  // namespace metabuffer::test::composer_test
