#include "tlm/payload.h"

#include <catch2/catch.hpp>

namespace metabuffer::test::payload_test {
namespace {

// Nothing in the machine copies a payload; an interconnect that a user puts between two blocks may.
TEST_CASE("payload: a copy of a payload has a copy of what it carries") {
    tlm::Message<tlm::PipelineFrame> message;
    message->frame = 5;
    message->cycle = 1234;

    ::tlm::tlm_generic_payload fresh;
    fresh.deep_copy_from(message.payload());  // makes an extension
    auto* made = fresh.get_extension<tlm::PipelineFrame>();
    REQUIRE(made != nullptr);
    CHECK(made != &*message);
    CHECK(made->frame == 5);
    CHECK(made->cycle == 1234);

    message->frame = 6;
    message->cycle = 4321;
    fresh.deep_copy_from(message.payload());  // fills the one that is there
    CHECK(fresh.get_extension<tlm::PipelineFrame>() == made);
    CHECK(made->frame == 6);
    CHECK(made->cycle == 4321);
    fresh.clear_extension(made);
    delete made;  // the payload's: it has no memory manager that would free it
}

}  // namespace
}  // namespace metabuffer::test::payload_test
