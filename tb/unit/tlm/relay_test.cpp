#include "tlm/relay.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <vector>

using metabuffer::tlm::Relay;

TEST_CASE("relay: a message has arrived when pass() returns, hop after hop", "[relay]") {
    Relay relay;
    std::vector<int> visited;
    int depth = 0;
    int deepest = 0;
    std::function<void(int)> hop = [&](int hop_number) {
        deepest = std::max(deepest, ++depth);
        visited.push_back(hop_number);
        if (hop_number < 100'000) relay.pass([&hop, hop_number] { hop(hop_number + 1); });
        --depth;
    };
    relay.pass([&hop] { hop(0); });
    REQUIRE(visited.size() == 100'001);
    CHECK(visited.back() == 100'000);
    CHECK(deepest == 1);  // no hop runs within another
    relay.pass([&hop] { hop(99'999); });
    CHECK(visited.size() == 100'003);
}

TEST_CASE("relay: a message may start another relay, which ends first", "[relay]") {
    Relay up;
    Relay down;
    std::vector<int> visited;
    up.pass([&] {
        down.pass([&] { down.pass([&] { visited.push_back(1); }); });
        visited.push_back(2);
        up.pass([&] { visited.push_back(3); });
    });
    CHECK(visited == std::vector<int>{1, 2, 3});
}
