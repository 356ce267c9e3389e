// A composer's merge stage: a stage of its display's pipeline that merges the segment pixel of each raster position
// with the pixel from upstream. The FIFO has read the segment's pixels at the edge before, even if they came at that
// edge.
module merge_stage #(
    parameter int WINDOW_ROWS = 1,  // source rows in the window: 1, or 2 to smooth
    parameter int INDEX_BITS  = 32
) (
    input logic clk_i,
    input logic reset_i,  // synchronous, active high

    // Configuration, as of the composer.
    input logic [1:0]  composition_i,
    input logic        stall_mode_i,
    input logic [23:0] far_z_i,
    input logic [63:0] background_i,
    input logic        pipemaster_i,  // constant outside reset

    // The pipeline.
    input  logic        moving_i,  // the column does not stand still
    input  logic [63:0] pipe_pixel_i,
    input  logic        pipe_lost_i,
    output logic [63:0] pipe_pixel_o,
    output logic        pipe_valid_o,
    output logic        pipe_lost_o,
    output logic        stall_o,

    // The position that this edge composites, and the next one.
    input logic                  running_i,
    input logic                  covered_i,
    input logic                  again_i,
    input logic                  smooths_i,
    input logic                  own_is_second_i,
    input logic [6:0]            weight_x_i,
    input logic [6:0]            weight_y_i,
    input logic                  running_next_i,
    input logic                  covered_next_i,
    input logic [INDEX_BITS-1:0] newest_next_i,

    // The frame, now and after this edge.
    input logic                  abandoned_i,
    input logic                  abandoned_next_i,
    input logic [INDEX_BITS-1:0] arrived_i,      // before this edge
    input logic [3:0]            taken_count_i,  // at this edge

    // The FIFO's words: of the position's own source row, and of the other one.
    input logic [63:0] word_i,
    input logic [63:0] next_word_i,
    input logic [63:0] row_word_i,
    input logic [63:0] row_next_word_i,

    output logic missing_o,  // a segment pixel that the position needs has not come

    // Status, as of the composer.
    output logic composited_o,
    output logic starved_o,
    output logic replayed_o,
    output logic stalled_o
);
  localparam logic [1:0] COMPOSE_Z = 2'd0;
  localparam logic [1:0] COMPOSE_Z_ALPHA_KEY = 2'd1;

  logic [63:0] local_pixel, merged_pixel, upstream_pixel;
  logic        upstream_lost, shows, missing_next;

  assign upstream_pixel = pipemaster_i ? background_i : pipe_pixel_i;
  assign upstream_lost = pipe_lost_i && !pipemaster_i;
  assign shows = covered_i && !missing_o && !abandoned_i;
  // Pixels from the first that has not come to the newest that is needed.
  logic [INDEX_BITS:0] needed_beyond;
  assign needed_beyond = {1'b0, newest_next_i} - {1'b0, arrived_i};
  assign missing_next = running_next_i && covered_next_i && !abandoned_next_i && !needed_beyond[INDEX_BITS] &&
                        needed_beyond >= (INDEX_BITS + 1)'(taken_count_i);

  // What shows of the back is back * (255 - alpha) / 255, rounded to nearest: exact for products up to 255 * 255.
  function automatic logic [7:0] over_channel(input logic [7:0] front, input logic [7:0] back,
                                              input logic [7:0] front_alpha);
    logic [16:0] product;
    logic [8:0] sum;
    product = {9'd0, back} * {9'd0, ~front_alpha} + 17'd128;
    sum = 9'((product + {9'd0, product[15:8]} + {1'b0, front, 8'd0}) >> 8);
    over_channel = sum[8] ? 8'd255 : sum[7:0];
  endfunction

  function automatic logic [63:0] over(input logic [31:0] back, input logic [55:0] front);
    over = {8'd0, front[55:32], over_channel(front[31:24], back[31:24], front[31:24]),
            over_channel(front[23:16], back[23:16], front[31:24]), over_channel(front[15:8], back[15:8], front[31:24]),
            over_channel(front[7:0], back[7:0], front[31:24])};
  endfunction

  always_comb begin : merge
    logic nearer;
    nearer = local_pixel[55:32] < upstream_pixel[55:32];
    unique case (composition_i)
      COMPOSE_Z: merged_pixel = nearer ? local_pixel : upstream_pixel;
      COMPOSE_Z_ALPHA_KEY: merged_pixel = nearer && local_pixel[31:24] != '0 ? local_pixel : upstream_pixel;
      default: begin
        if (nearer) merged_pixel = over(upstream_pixel[31:0], local_pixel[55:0]);
        else merged_pixel = over(local_pixel[31:0], upstream_pixel[55:0]);
      end
    endcase
  end

  if (WINDOW_ROWS > 1) begin : gen_smoothing
    logic [63:0] blended;
    pixel_blend blend (
        .own_i(own_is_second_i ? next_word_i : word_i),
        .beside_i(own_is_second_i ? word_i : next_word_i),
        .across_i(own_is_second_i ? row_next_word_i : row_word_i),
        .diagonal_i(own_is_second_i ? row_word_i : row_next_word_i),
        .weight_x_i,
        .weight_y_i,
        .far_z_i,
        .alpha_key_i(composition_i == COMPOSE_Z_ALPHA_KEY),
        .pixel_o(blended)
    );
    assign local_pixel = smooths_i ? blended : word_i;
  end else begin : gen_replication
    assign local_pixel = word_i;
    logic unused_smoothing;
    assign unused_smoothing =
        ^{smooths_i, own_is_second_i, weight_x_i, weight_y_i, far_z_i, next_word_i, row_word_i, row_next_word_i};
  end

  always_ff @(posedge clk_i) begin : registers
    if (reset_i) begin
      pipe_pixel_o <= '0;
      pipe_valid_o <= 1'b0;
      pipe_lost_o <= 1'b0;
      missing_o <= 1'b0;
      stall_o <= 1'b0;
      composited_o <= 1'b0;
      starved_o <= 1'b0;
      replayed_o <= 1'b0;
      stalled_o <= 1'b0;
    end else begin
      if (moving_i) begin
        pipe_valid_o <= running_i;
        pipe_lost_o <= running_i && (upstream_lost || abandoned_i);
        if (!running_i) pipe_pixel_o <= '0;
        else pipe_pixel_o <= shows ? merged_pixel : upstream_pixel;
      end
      missing_o <= missing_next;
      stall_o <= stall_mode_i && missing_next;
      composited_o <= moving_i && running_i;
      starved_o <= moving_i && running_i && missing_o;
      replayed_o <= moving_i && running_i && shows && again_i;
      stalled_o <= !moving_i && stall_o;
    end
  end
endmodule
