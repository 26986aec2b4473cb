#include "simulator/rig/modbus_frames.h"

#include <gtest/gtest.h>

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;

// The example of the specification's CRC chapter (unit 2, function 7): 0x41 0x12 follow.
TEST(ModbusFramesTest, CrcIsThatOfTheSpecification) {
  EXPECT_EQ(modbus_crc(ModbusBytes{0x02, 0x07}), 0x1241);
  EXPECT_EQ(rtu_frame(0x02, ModbusBytes{0x07}), (ModbusBytes{0x02, 0x07, 0x41, 0x12}));
}

TEST(ModbusFramesTest, RequestsAreFoundHoweverTheStreamIsSplit) {
  const ModbusBytes read{0x03, 0x10, 0x14, 0x00, 0x02};
  const ModbusBytes write{0x10, 0x62, 0x00, 0x00, 0x02, 0x04, 0x00, 0x01, 0x02, 0x03};
  ModbusBytes stream = rtu_frame(1, read);
  const ModbusBytes second = rtu_frame(7, write);
  stream.insert(stream.end(), second.begin(), second.end());
  for (std::size_t piece = 1; piece <= stream.size(); ++piece) {
    RtuReceiver receiver;
    std::vector<ModbusRequest> requests;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      const std::size_t count = std::min(piece, stream.size() - at);
      receiver.add(std::span(stream).subspan(at, count), RtuReceiver::Time(milliseconds(500)));
      while (auto request = receiver.next()) requests.push_back(*request);
    }
    ASSERT_EQ(requests.size(), 2U) << piece;
    EXPECT_EQ(requests[0].unit, 1);
    EXPECT_EQ(requests[0].pdu, read);
    EXPECT_EQ(requests[1].unit, 7);
    EXPECT_EQ(requests[1].pdu, write);
  }
}

TEST(ModbusFramesTest, AfterAWrongChecksumDataAreDroppedUntilAPause) {
  const ModbusBytes good = rtu_frame(1, ModbusBytes{0x03, 0x10, 0x14, 0x00, 0x02});
  ModbusBytes bad = good;
  bad[4] ^= 0x40;
  RtuReceiver receiver;
  receiver.add(bad, RtuReceiver::Time(milliseconds(500)));
  EXPECT_FALSE(receiver.next());
  receiver.add(good, RtuReceiver::Time(milliseconds(501)));
  EXPECT_FALSE(receiver.next());
  receiver.add(good, RtuReceiver::Time(milliseconds(600)));
  EXPECT_TRUE(receiver.next());
}

TEST(ModbusFramesTest, AnIncompleteRequestIsDroppedAfterAPause) {
  const ModbusBytes good = rtu_frame(1, ModbusBytes{0x03, 0x10, 0x14, 0x00, 0x02});
  RtuReceiver receiver;
  receiver.add(std::span(good).first(5), RtuReceiver::Time(milliseconds(500)));
  EXPECT_FALSE(receiver.next());
  receiver.add(good, RtuReceiver::Time(milliseconds(600)));
  EXPECT_TRUE(receiver.next());
}

TEST(ModbusFramesTest, AnUnknownFunctionIsPassedOn) {
  RtuReceiver receiver;
  receiver.add(rtu_frame(1, ModbusBytes{0x2b, 0x0e, 0x01, 0x00}),
               RtuReceiver::Time(milliseconds(500)));
  const auto request = receiver.next();
  ASSERT_TRUE(request);
  EXPECT_EQ(request->pdu[0], 0x2b);
}

TEST(ModbusFramesTest, TcpHeaderCarriesTransactionAndLength) {
  const ModbusBytes pdu{0x03, 0x10, 0x14, 0x00, 0x02};
  const ModbusBytes frame = tcp_frame(0x1234, 9, pdu);
  EXPECT_EQ(frame, (ModbusBytes{0x12, 0x34, 0, 0, 0, 6, 9, 0x03, 0x10, 0x14, 0x00, 0x02}));
  TcpReceiver receiver;
  receiver.add(std::span(frame).first(9));
  EXPECT_FALSE(receiver.next());
  receiver.add(std::span(frame).subspan(9));
  receiver.add(frame);
  for (int i = 0; i < 2; ++i) {
    const auto request = receiver.next();
    ASSERT_TRUE(request);
    EXPECT_EQ(request->transaction, 0x1234);
    EXPECT_EQ(request->unit, 9);
    EXPECT_EQ(request->pdu, pdu);
  }
  EXPECT_FALSE(receiver.next());
  EXPECT_FALSE(receiver.is_broken());
}

TEST(ModbusFramesTest, OtherProtocolsBreakTheConnection) {
  const std::string http = "GET / HTTP/1.1\r\n";
  TcpReceiver receiver;
  receiver.add(ModbusBytes(http.begin(), http.end()));
  EXPECT_FALSE(receiver.next());
  EXPECT_TRUE(receiver.is_broken());
}

}  // namespace
}  // namespace raywalk::capture
