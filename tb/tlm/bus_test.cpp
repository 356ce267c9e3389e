#include "tlm/bus.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "socket_bench.h"
#include "tlm/dvi_display.h"

namespace metabuffer::test::bus_test {
namespace {

constexpr int kDisplays = 3;

struct BusBench {
    Initiator<tlm::BusTransfer> framebuffer{"framebuffer"};
    tlm::Bus bus{"bus", kDisplays};
    std::vector<std::unique_ptr<Target<tlm::BusTransfer>>> composers;
    tlm::Message<tlm::BusTransfer> transfer;

    BusBench() {
        framebuffer.socket.bind(bus.framebuffer_socket);
        for (int display = 1; display <= kDisplays; ++display) {
            composers.push_back(
                std::make_unique<Target<tlm::BusTransfer>>(("composer_" + std::to_string(display)).c_str()));
            bus.composer_socket(display).bind(composers.back()->socket);
        }
        elaborate();
    }
};

TEST_CASE("bus: a transfer goes to the composer of the display that the address names and to no other") {
    BusBench dut;
    for (int display = 1; display <= kDisplays; ++display) {
        INFO("display " << display);
        dut.transfer->frame = 10 * display;
        dut.composers[static_cast<std::size_t>(display) - 1]->on_transport =
            [&](::tlm::tlm_generic_payload& payload) {
                CHECK(&payload == &dut.transfer.payload());
                CHECK(tlm::content_of<tlm::BusTransfer>(payload).frame == 10 * display);
                tlm::content_of<tlm::BusTransfer>(payload).pixels_taken = display;
            };
        ::tlm::tlm_generic_payload& payload = dut.transfer.payload();
        CHECK(payload.get_response_status() == ::tlm::TLM_INCOMPLETE_RESPONSE);
        payload.set_address(static_cast<sc_dt::uint64>(display));
        CHECK(dut.framebuffer.send(payload) == ::tlm::TLM_OK_RESPONSE);
        CHECK(dut.transfer->pixels_taken == display);  // the answer comes back in the transfer
        for (int other = 1; other <= kDisplays; ++other) {
            CHECK(dut.composers[static_cast<std::size_t>(other) - 1]->transports ==
                  (other <= display ? 1 : 0));
        }
    }
}

TEST_CASE("bus: a composer's notice goes back to the input framebuffer with its phase") {
    BusBench dut;
    tlm::Message<tlm::BusNotice> notice;
    std::vector<int> from;
    std::vector<bool> tableready;
    dut.framebuffer.on_notice = [&](::tlm::tlm_generic_payload& payload, const ::tlm::tlm_phase& phase) {
        from.push_back(static_cast<int>(payload.get_address()));
        tableready.push_back(phase == tlm::tableready_phase);
        CHECK(tlm::content_of<tlm::BusNotice>(payload).slot_cycle == 77);
    };
    notice->slot_cycle = 77;
    notice.payload().set_address(3);
    dut.composers[2]->notify(notice.payload(), tlm::busready_phase);
    notice.payload().set_address(1);
    dut.composers[0]->notify(notice.payload(), tlm::tableready_phase);
    CHECK(from == std::vector<int>{3, 1});
    CHECK(tableready == std::vector<bool>{false, true});
}

// ---- the smallest block ----

TEST_CASE("dvi display: receives each frame as it is on the link") {
    Initiator<tlm::ShownFrame> framebuffer("framebuffer");
    tlm::DviDisplay display("display");
    framebuffer.socket.bind(display.dvi_socket);
    elaborate();
    tlm::Message<tlm::ShownFrame> shown;
    CHECK(framebuffer.send(shown.payload()) == ::tlm::TLM_OK_RESPONSE);  // nobody listens
    const ColourImage image(2, 1, 0x123456);
    int frame = -1;
    const ColourImage* taken = nullptr;
    display.on_frame([&](int number, const ColourImage* colours) {
        frame = number;
        taken = colours;
    });
    shown->frame = 4;
    shown->image = &image;
    CHECK(framebuffer.send(shown.payload()) == ::tlm::TLM_OK_RESPONSE);
    CHECK(frame == 4);
    CHECK(taken == &image);
    CHECK(report_of_empty_payload(framebuffer) == kExtensionReport);
}

}  // namespace
}  // namespace metabuffer::test::bus_test
