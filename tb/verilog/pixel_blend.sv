// The local pixel of a raster pixel where a composer smooths: colour and alpha of up to four source pixels, mixed, and
// Z of its own one. See blend() in model/datapath/smoothing.h.
module pixel_blend (
    input  logic [63:0] own_i,
    input  logic [63:0] beside_i,
    input  logic [63:0] across_i,
    input  logic [63:0] diagonal_i,
    input  logic [6:0]  weight_x_i,   // of beside and diagonal, of 256
    input  logic [6:0]  weight_y_i,   // of across and diagonal
    input  logic [23:0] far_z_i,      // Z of the far plane
    input  logic        alpha_key_i,  // alpha 0 hides a pixel
    output logic [63:0] pixel_o
);
  // A neighbour that a viewer does not see counts as the own pixel.
  function automatic logic [31:0] seen_or_own(input logic [55:0] neighbour, input logic [31:0] own,
                                              input logic [23:0] far_z,
                                              input logic alpha_key);
    seen_or_own = neighbour[55:32] == far_z || (alpha_key && neighbour[31:24] == '0) ? own : neighbour[31:0];
  endfunction

  // 256 times what lies weight / 256 of the way between them.
  function automatic logic [15:0] between(input logic [7:0] from, input logic [7:0] to, input logic [6:0] weight);
    logic signed [8:0] way;
    logic signed [15:0] part;
    way = $signed({1'b0, to}) - $signed({1'b0, from});
    part = way * $signed({1'b0, weight});
    between = {from, 8'd0} + part;
  endfunction

  // The same between two of those, rounded to the whole.
  function automatic logic [7:0] rounded(input logic [15:0] from, input logic [15:0] to, input logic [6:0] weight);
    logic signed [16:0] way;
    logic signed [23:0] part;
    way = $signed({1'b0, to}) - $signed({1'b0, from});
    part = way * $signed({1'b0, weight});
    rounded = 8'(({from, 8'd0} + part + 24'h8000) >> 16);
  endfunction

  logic [31:0] own, beside, across, diagonal, mixed;
  assign own = own_i[31:0];
  assign beside = seen_or_own(beside_i[55:0], own, far_z_i, alpha_key_i);
  assign across = seen_or_own(across_i[55:0], own, far_z_i, alpha_key_i);
  assign diagonal = seen_or_own(diagonal_i[55:0], own, far_z_i, alpha_key_i);

  for (genvar channel = 0; channel < 4; channel = channel + 1) begin : gen_channel
    assign mixed[8*channel +: 8] = rounded(between(own[8*channel +: 8], beside[8*channel +: 8], weight_x_i),
                                           between(across[8*channel +: 8], diagonal[8*channel +: 8], weight_x_i),
                                           weight_y_i);
  end

  // A pixel that the key hides stays hidden.
  assign pixel_o = {8'd0, own_i[55:32], alpha_key_i && own[31:24] == '0 ? own : mixed};

  logic unused;
  assign unused = ^{own_i[63:56], beside_i[63:56], across_i[63:56], diagonal_i[63:56]};
endmodule
