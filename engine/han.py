"""Chinese writing: it has no spaces, and two spellings.

Every Chinese character counts as a word of its own, so that whatever works on words works
on Chinese; :func:`apart` puts the spaces in. Characters that are written in two ways (as in Taiwan and Hong Kong, and
by recognisers as they please) are read as the simplified ones.
"""

from __future__ import annotations

import re
from typing import Final

HAN: Final = r"[\u3007\u3400-\u9fff\uf900-\ufaff]"
"""A Chinese character, as a regular expression; 〇 is one."""

_TRADITIONAL = (
    "丟並乾佈併來侷倉個們側偵傢億儲兒內兩凈別則剋剎剛動務勞匯區卽參唸問啓啟單喲嗎嗶噹嚮國圍園報場塊夠夾妳"
    "寢寫將尋對導崗帶幫幹幾庫廚廢廳張彆彎彔彙後徑從應掃揀換揮搖撿擱擺攏於昇時暫曏書會東枴柺査條棄榦樁樓標"
    "樣橋機橫檢檯櫃櫥歸沒淨準滅滙潔為烏無煞煩燈爲牀牠現環甚畫畵當發盃盤碼礙祂積竈竪筆箇簍簽籤約紅紙紹終結"
    "給統綠綫維綵緊緑線編緩繞繼續纔翫聲聽膠臥臺與舉舘萬著蒐蔘藍處號蝸衕衛裏裡襬見視覺觀託記訪設許訴試話該"
    "說説誰調請謊講謝護讀變讓豎負貨買趕跡蹟蹤車軌輕轉辦迴這週進運過遞遠還邊邏釐針鈡鈴銀錄録錶鍼鍾鏇鐘長門"
    "閃閉開間閤闆關陞陽隨隻雙雜離電靜韆響順頓領頭顆顏顔類顧顯颱飛飯餘館餵馬駕駛體髮鬆鳴麪麫麯麴麵麼麽黃點"
    "齊齣龜"
)
_SIMPLIFIED = (
    "丢并干布并来局仓个们侧侦家亿储儿内两净别则克刹刚动务劳汇区即参念问启启单哟吗哔当向国围园报场块够夹你"
    "寝写将寻对导岗带帮干几库厨废厅张别弯录汇后径从应扫拣换挥摇捡搁摆拢于升时暂向书会东拐拐查条弃干桩楼标"
    "样桥机横检台柜橱归没净准灭汇洁为乌无刹烦灯为床它现环什画画当发杯盘码碍它积灶竖笔个篓签签约红纸绍终结"
    "给统绿线维彩紧绿线编缓绕继续才玩声听胶卧台与举馆万着搜参蓝处号蜗同卫里里摆见视觉观托记访设许诉试话该"
    "说说谁调请谎讲谢护读变让竖负货买赶迹迹踪车轨轻转办回这周进运过递远还边逻厘针钟铃银录录表针钟旋钟长门"
    "闪闭开间合板关升阳随只双杂离电静千响顺顿领头颗颜颜类顾显台飞饭余馆喂马驾驶体发松鸣面面曲曲面么么黄点"
    "齐出龟"
)
SIMPLER: Final = str.maketrans(_TRADITIONAL, _SIMPLIFIED)
"""For ``str.translate``: traditional characters of common commands and household words, and what they are read as."""

_HAN = re.compile(rf"\s*({HAN})\s*")


def is_chinese(text: str) -> bool:
    """Whether there is a Chinese character in ``text``."""
    return _HAN.search(text) is not None


def apart(text: str) -> str:
    """``text`` with every Chinese character as a word of its own."""
    return " ".join(_HAN.sub(r" \1 ", text).split())
