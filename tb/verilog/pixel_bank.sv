// One bank of a composer's local memory: a write port and a registered read port, as a block RAM has them. A word that
// is written at the edge that reads it is not seen: the FIFO has a bypass for it.
module pixel_bank #(
    parameter int DEPTH = 512,
    localparam int ADDRESS_BITS = $clog2(DEPTH)
) (
    input  logic                    clk_i,
    input  logic                    write_i,
    input  logic [ADDRESS_BITS-1:0] write_address_i,
    input  logic [2:0]              write_lane_i,     // which of the beat's words
    input  logic [511:0]            words_i,
    input  logic                    read_i,
    input  logic [ADDRESS_BITS-1:0] read_address_i,
    output logic [63:0]             word_o
);
  logic [63:0] storage[DEPTH];

  always_ff @(posedge clk_i) begin
    if (write_i) storage[write_address_i] <= words_i[64*write_lane_i +: 64];
    if (read_i) word_o <= storage[read_address_i];
  end
endmodule
