// The images of the report of a trade.
#pragma once

#include <span>
#include <vector>

#include "core/judge/trade/trade_result.h"
#include "core/judge/trade/trade_view.h"
#include "core/report/report.h"

namespace raywalk {

// The truth of the pictured view beside the error of a setting there, for every setting, or where
// there are many for those on the PSNR front and nearest to it. Throws as Renderer does;
// Interrupted.
std::vector<ReportImage> trade_images(const Trade& trade, std::span<const TradeRoom> rooms);

}  // namespace raywalk
