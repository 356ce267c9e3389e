// What a blend counter divides by: 2^23 / multiple, rounded up. One table instead of a divider.
module blend_reciprocal (
    input  logic [7:0]  multiple_i,   // 2..255
    output logic [22:0] reciprocal_o
);
  localparam int BITS = 23;
  localparam int ENTRIES = 256;

  function automatic logic [ENTRIES*BITS-1:0] all_reciprocals();
    all_reciprocals = '0;
    for (int multiple = 2; multiple < ENTRIES; multiple = multiple + 1) begin
      all_reciprocals[BITS*multiple +: BITS] = BITS'(((1 << BITS) + multiple - 1) / multiple);
    end
  endfunction

  localparam logic [ENTRIES*BITS-1:0] RECIPROCALS = all_reciprocals();

  assign reciprocal_o = RECIPROCALS[BITS*multiple_i +: BITS];
endmodule
