// Hybrid connection: the angle at which the columns of an output panorama change from one line of a
// cell to the next (section IV-B of the paper).
//
// At a corner the lines of two sides meet at the angle c = atan2(a, b), measured at the viewpoint
// from the normal of the first side; a and b are the distances to the second and the first side.
// The paper allows incidence angles up to k only, so the lines connect at clamp(c, 90 deg - k, k):
// inside that range the connection is physical (both lines captured the same ray, D_m = 0), outside
// it is not. k = 45 deg is LFU, k = 90 deg is Ray-space360: all three are this one rule.
#pragma once

namespace raywalk {

struct ConnectionRule {
  double k_rad = 0.0;        // in [pi/4, pi/2]
  double overlap_rad = 0.0;  // width of the blend, in [0, pi/4]
};

// A corner as seen from the viewpoint; metres, all >= 0.
struct CornerView {
  double to_next_side_m = 0.0;   // a
  double to_this_side_m = 0.0;   // b
  double overhang_this_m = 0.0;  // how far this side's line is captured beyond the corner
  double overhang_next_m = 0.0;  // how far the next side's line is captured beyond the corner
};

// Angles from the normal of this side towards the next side, in [0, pi/2].
struct CornerConnection {
  double corner_rad = 0.0;
  double cut_rad = 0.0;          // where the two lines connect
  double blend_begin_rad = 0.0;  // <= cut_rad; this side alone up to here
  double blend_end_rad = 0.0;    // >= cut_rad; the next side alone from here
  bool limited = false;          // the overhang does not reach the angle given by k
};

// Smallest and largest angle at which both lines can be read: this side's line covers angles up to
// atan2(a + o_this, b), the next side's line those from atan2(a, b + o_next) on.
struct SharedAngles {
  double begin_rad = 0.0;
  double end_rad = 0.0;
};
SharedAngles shared_angles(const CornerView& corner);

// clamp(c, 90 deg - k, k), whatever the overhang.
double hybrid_cut(const CornerView& corner, double k_rad);

// The hybrid connection where the overhang suffices; else the cut moves continuously towards the
// physical one. The blend is centred on the cut and narrowed to the angles that both lines cover.
CornerConnection connect_corner(const CornerView& corner, const ConnectionRule& rule);

// Weight of the next side's line at an angle: 0 before the blend, 1 after it, linear within.
double next_side_weight(const CornerConnection& connection, double angle_rad);

}  // namespace raywalk
