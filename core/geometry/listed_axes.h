// What is wrong with a frame list whose axes are not those of its pictures.
#pragma once

#include <Eigen/Core>
#include <string>

namespace raywalk {

// "x", "-z", ...: the axis nearest to a direction.
std::string nearest_axis(const Eigen::Vector3d& direction);

// The likely cause and its remedy if stations that are listed along x move along `along_x` by the
// pictures, and those listed along z along `along_z`: axes by the names above, "" where nothing is
// known. Empty if they move as listed.
std::string likely_fault_of_axes(const std::string& along_x, const std::string& along_z);

}  // namespace raywalk
