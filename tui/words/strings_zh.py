"""The words of the console in Chinese: the same names as in ``tui.words.strings``, with the same slots.

It is read where somebody wants Chinese (``tui.words.language``). What is not here is the same in both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tui.words import settings_zh

if TYPE_CHECKING:
    from engine.events import State

STATE_WORDS: Final[dict[State, str]] = {
    "IDLE": "就绪",
    "LISTENING": "聆听中",
    "TRANSCRIBING": "识别中",
    "DECIDING": "决策中",
    "PLANNING": "规划中",
    "CLARIFYING": "提问",
    "SPEAKING": "说话中",
    "ACTING": "执行中",
    "FEEDBACK": "核对中",
    "WAITING": "就绪",
}
STARTING: Final = "启动中"
BROKEN: Final = "故障"
ESTOP: Final = "急停"
ESTOP_HOLDS: Final = "机器人不会动；{release}解除"
ESTOP_HOLDS_WAITING: Final = "机器人不会动；{release}解除，并放弃等待中的请求"
ESTOP_RELEASE: Final = "{release}解除"
ESTOP_COMES: Final = "机器人一就绪就按下急停；{release}取消"
BY_HAND_STANDS: Final = "{why} · {back} 返回 · {interrupt} 停止"
BY_HAND: Final = (
    "手动 {speed:g}米/秒 · {hand_ahead} {hand_back} {hand_left} {hand_right} 行驶 · {hand_faster} {hand_slower} 速度 · "
    "{hand_aside_left} {hand_aside_right} 平移 · {back} 返回 · {interrupt} 停止"
)
ENDED: Final = "已结束"
TASK: Final = "任务"

# Keys
KEY_NAMES: Final = {"pageup": "上翻页", "pagedown": "下翻页", "enter": "回车", "space": "空格", "tab": "tab"}
KEY_WORDS: Final = {
    "interrupt": "停止",
    "wake": "唤醒",
    "end_task": "结束",
    "type": "输入",
    "help": "帮助",
    "leave": "退出",
    "leave_now": "退出",
    "back": "返回",
    "pane_next": "窗格",
    "palette": "查找",
    "send": "发送",
    "earlier": "上一条",
}
ABOUT_KEYS: Final = {
    "interrupt": "立即停止一切，先停运动。在任何地方都有效，不改变其他东西。",
    "back": "返回一步，不停止任何东西：离开页面、面板、窗格、地图、手动驾驶或输入行。",
    "wake": "开始聆听。正在说话或行动的机器人会先停下。",
    "end_task": "停下，收回手臂，清空对话，开始新任务。",
    "resume": "继续：从机器人现在的位置做完被打断的事。",
    "undo": "撤销：如果有办法，把上次做的事还原。",
    "again": "把上一个计划再做一次。",
    "queue_up": "选择一条等待中的请求。",
    "queue_down": "选择一条等待中的请求。",
    "queue_drop": "取消选中的请求。",
    "queue_earlier": "让它早点开始。",
    "queue_later": "让它晚点开始。",
    "queue_change": "把它拿回输入行修改。",
    "speed_down": "降低机器人的限速：快、较快、中、慢。",
    "speed_up": "提高机器人的限速。",
    "type": "转到输入行，输入请求。",
    "add": "把这一行的请求排到正在做和等待的事之后，不打断任何事。",
    "estop": "急停：解除之前机器人不会动。",
    "release": "解除急停。",
    "by_hand": "手动驾驶，或不再手动：按下方向才会结束计划。",
    "help": "显示按键，先列当前位置的；或离开该页。",
    "leave": "离开页面；在主屏幕上则退出，还有没做完的事时会再问一次。",
    "leave_now": "立即退出；机器人会停下。",
    "log": "改为显示日志（小终端）。",
    "map": "在地图上指一处、放大，或让机器人前往那里（会先问）；再按一次结束。",
    "camera": "显示或隐藏相机画面。",
    "timeline": "改为显示各轮对话（小终端）。",
    "turn_back": "看上一轮。",
    "turn_on": "看下一轮；到最新一轮后自动跟随。",
    "turn": "显示或离开整轮详情。",
    "palette": "查找所有能做的事：输入其中几个字即可。",
    "recall": "搜索以前提过的请求。",
    "pane_next": "转到下一个窗格，最后一个之后是输入行。",
    "pane_previous": "转到上一个窗格，第一个之前是输入行。",
    "pane_conversation": "转到对话。",
    "pane_plan": "转到计划。",
    "pane_actions": "转到动作。",
    "pane_map": "转到地图，并在上面指点。",
    "pane_log": "转到日志。",
    "pane_turns": "转到各轮。",
    "pane_camera": "转到相机画面。",
    "zoom": "让当前窗格占满，或恢复原样。",
    "border_left": "左侧窗格变窄；在日志和各轮处是日志变窄。",
    "border_right": "左侧窗格变宽；在日志和各轮处是日志变宽。",
    "copy": "复制本轮；再按一次：对话、计划、动作、日志。在 tmux 中须先 set -s set-clipboard on。",
    "save": "保存会话和屏幕截图，并说明保存在哪里。",
    "link": "显示或隐藏终端连接的速度。",
    "settings": "设置：查看、更改，或离开该页。",
    "doctor": "检查 sayso 需要的一切，或离开该页。",
    "examine": "再检查一遍。",
    "older": "往回翻：有键盘焦点的窗格，否则是对话。",
    "newest": "回到最新的内容：有键盘焦点的窗格，否则是对话。",
    "newer": "往前翻。",
    "line_up": "往回滚一行。",
    "line_down": "往前滚一行。",
    "map_nearer": "放大地图。",
    "map_farther": "缩小地图。",
    "map_whole": "显示整张地图。",
    "map_follow": "跟随机器人，或不再跟随。",
    "map_legend": "说明地图上的符号，并列出看到的人和东西；或不再显示。",
    "map_point_left": "在地图上移动光标。",
    "map_point_right": "在地图上移动光标。",
    "map_point_up": "在地图上移动光标。",
    "map_point_down": "在地图上移动光标。",
    "map_left": "平移地图。",
    "map_right": "平移地图。",
    "map_up": "平移地图。",
    "map_down": "平移地图。",
    "map_next": "指向下一个或上一个地点或东西。",
    "map_previous": "指向下一个或上一个地点或东西。",
    "map_go": "前往光标处：按一次会询问，再按一次前往。",
    "map_here": "告诉机器人它在光标处。",
    "map_turn_left": "告诉机器人它的朝向更偏左。",
    "map_turn_right": "告诉机器人它的朝向更偏右。",
    "log_level": "只显示较重要的日志：信息、警告、错误；然后全部。",
    "log_part": "只显示一个部分的日志：下一个部分；最后一个之后是全部。",
    "log_all": "重新显示所有日志。",
    "log_find": "搜索日志。",
    "log_trouble_before": "转到上一个警告或错误。",
    "log_trouble_after": "转到下一个警告或错误。",
    "log_turn": "打开所选行所在的一轮，或最新的警告或错误所在的一轮。",
    "log_follow": "显示最新一行日志，并一直跟随。",
    "unfold": "展开或折叠提示词、模型写的内容和 JSON。",
    "lines_up": "向上滚动。",
    "lines_down": "向下滚动。",
    "hand_ahead": "按住时前进。",
    "hand_back": "后退。",
    "hand_left": "左转。",
    "hand_right": "右转。",
    "hand_aside_left": "向左平移（轮子允许时）。",
    "hand_aside_right": "向右平移（轮子允许时）。",
    "hand_faster": "加速。",
    "hand_slower": "减速。",
    "setting_up": "上一项设置。",
    "setting_down": "下一项设置。",
    "setting_before": "显示前一个值。",
    "setting_after": "显示后一个值。",
    "setting_take": "保存显示的值，或取下一个；或自己输入一个。",
    "setting_default": "恢复默认值。",
    "setting_find": "搜索设置。",
}

# Panes
PANES: Final = {
    "conversation": "对话",
    "plan": "计划",
    "actions": "动作",
    "map": "地图",
    "log": "日志",
    "turns": "各轮",
    "camera": "相机",
}
PANE_ROBOT: Final = "机器人"
ZOOM_BACK: Final = "{zoom} 恢复"
NO_FILE: Final = "{} 不是文件"
NO_SIZES: Final = "里面没有窗格的大小"
SIZES_NOT_KEPT: Final = "窗格大小没有保存到以后的会话：{}"

# Actions
STEPS_ENDED: Final = "{}/{} 已结束"
STEPS_FAILED: Final = "{} 个失败"
REQUESTS_WAIT: Final = "{} 个在等待"
ANSWER_FIRST: Final = "先等您回答"
QUEUE_KEYS: Final = (
    "{queue_drop} 取消 · {queue_earlier} {queue_later} 移动 · {queue_change} 修改 · "
    "{queue_up}{queue_down} 选择 · {interrupt} 停止"
)
TAKEN_BACK: Final = "{send}把它放回原处 · 清空这一行就不做了"
PUTS_BACK: Final = "放回"
TAKEN_BACK_TOO_LATE: Final = "它已经开始或结束了。"
FOLLOW_UPS: Final = {"resume": "继续", "undo": "撤销", "again": "再来一次"}
NOT_OFFERED: Final = {
    "resume": "没有被打断、可以继续的事。",
    "undo": "没有什么可以撤销的。",
    "again": "还没有可以再做一次的计划。",
}
NOT_NOW: Final = "机器人正在做事：{interrupt} 停止它。"
NOWHERE: Final = "不知道机器人在哪里"
ROBOT_GONE: Final = "机器人不在。"
NOT_WHILE_PRESSED: Final = "急停按下了：{release}解除。"
NO_UNDO: Final = "不能撤销：{why}"
KEY_STOPS: Final = "{interrupt} 停止"

# Camera
NO_PICTURE: Final = "等待画面…"

# Map
MAP_KEYS: Final = "{map} 指点 · {camera} 相机"
MAP_FOLLOWS: Final = ("{map_follow} 跟随", "{map_follow} 停住")
MAP_POINTS: Final = "{map_legend} 图例 · {map_nearer}{map_farther} 缩放 · {map} 返回"
MAP_SIGNS: Final = {
    "robot": "机器人和它的朝向",
    "robot_outside": "机器人在画面之外的那一边",
    "path": "前面的路",
    "trail": "走过的路",
    "scan": "地图上没有的障碍物",
    "thing": "东西，用它自己的颜色",
    "round": "圆的东西",
    "stale": "很久以前看到的东西，可能移动了",
    "person": "人，用衣服的颜色",
    "person_stale": "很久以前看到的人",
    "hand": "手",
    "held": "手里拿着东西",
}
GO_THERE: Final = "{asked}吗？{map_go}：是 · 其他键：否"
ENTER_GOES: Final = "{map_go}前往"
ENTER_GOES_TO: Final = "{map_go}前往 {goal}"
NO_WAY_TO_SAY: Final = "这里没有地名 · {map_next} 选一个"
SEEN_AGO: Final = "{}看到"
JUST_NOW: Final = "刚刚"
SECONDS_AGO: Final = "{} 秒前"
MINUTES_AGO: Final = "{} 分钟前"
HOURS_AGO: Final = "{} 小时前"

# Conversation
YOU: Final = "你"
ROBOT: Final = "机器人"
HOW_SAID: Final[dict[str, str]] = {"speech": "", "text": "输入", "overheard": "旁听"}
CUT_OFF: Final = "被打断"
WELCOME: Final = "按{wake}键说话，或直接输入机器人要做的事。"
WELCOME_TYPING: Final = "输入机器人要做的事。"
TOUR: Final = (
    "{interrupt} 随时立即停止机器人，在任何页面都有效 · {back} 返回",
    "{help} 显示所有按键 · {palette} 查找所有能做的事",
    "{pane_next} 转到窗格，在那里单个字母是按键 · {type} 转到输入行",
)
EXAMPLES: Final = ("向左转90度", "你在哪里？")
TRY: Final = "试试："
STOPPED: Final = "已停止"
STOPPED_BY: Final = "已停止：{reason}"
WAITS: Final = "等待中"
MORE_WAIT: Final = "… 还有 {} 条"
LOST: Final = {
    "dropped": "已取消",
    "interrupted": "没有开始",
    "replaced": "开始之前就被取代",
    "rejected": "没有接受：机器人正忙",
    "left": "放弃：它所跟随的事没有做成",
}
LOST_BY: Final = "没有开始：{reason}"
NO_ENGINE: Final = "没有开始：引擎没有启动"
WAS_PRESSED: Final = "没有做：当时急停按下了"
REPLACED_PLANNING: Final = "规划时被取代"
REPLACED_ASKED: Final = "询问时被取代"
DECLINED: Final = "放弃：回答不是指令"
UNANSWERED: Final = "放弃：没有得到回答"
QUESTION_WITHDRAWN: Final = "问题已撤回：{reason}"
REPLACED: Final = "被新的请求取代"
NEW_TASK: Final = "新任务"
REASONS: Final = {
    "interrupt": "停止键",
    "wake": "唤醒",
    "say": "新请求",
    "heard": "听到的话",
    "end_task": "结束任务",
    "quit": "退出",
    "halted": "机器人自己停下",
    "estop": "急停",
    "release": "急停解除",
    "drive": "手动驾驶",
    "by_hand": "手动驾驶",
    "stop": "停下",
    "replaced": "换成新请求",
    "shutdown": "关闭",
    "asked": "按要求",
    "finished by the dialogue": "对话结束",
    "asked to": "按要求",
    "a fault": "sayso 出错",
}
REJECTED: Final = {
    "no_speech": "没有人说话",
    "low_confidence": "没听清",
    "too_short": "太短",
    "empty": "没有识别出话来",
    "late": "来得太晚",
    "artefact": "不是人声",
}
NOT_HEARD: Final = "没听到"

# Plan
NO_PLAN: Final = "你的请求的计划会显示在这里。"
THINKING: Final = "思考中…"
WAITS_FOR: Final = "等待{parts}"
NO_ACTIONS: Final = "还没有动作。"
REFUSED: Final = "拒绝"
NO_PLAN_CAME: Final = "没有计划"
QUESTION: Final = "提问"
NO_ORDER: Final = "不是命令"
PLAN_BY: Final = {
    "phrases": "按已知句式",
    "reader": "由学习的理解器",
    "local": "由本机模型",
    "openai": "由云端模型",
    "dify": "由 Dify",
    "direct": "按原样",
}

# Robot
NO_ROBOT: Final = "机器人启动后会显示在这里。"
NO_MAP: Final = "正在载入地图…"
PART_WORDS: Final = {
    "robot": "机器人",
    "microphone": "麦克风",
    "recogniser": "识别",
    "planner": "规划",
    "model": "模型",
    "camera": "相机",
    "voice": "语音",
    "wake": "唤醒",
    "wake words": "唤醒词",
    "ros": "ROS",
}
LOADING: Final = "载入中"
LOADS: Final = "载入中"
LOADS_PARTS: Final = "{parts} · 请求会等待"
MISSING: Final = "缺少"
ALL_READY: Final = "各部分就绪"
OTHERS_READY: Final = "其余就绪"
BATTERY: Final = "电池"
BATTERY_LOW: Final = "电量低"
SPEED_LIMITS: Final = ("慢", "中", "较快", "快")
SPEED_LIMIT_IS: Final = "限速：{}"
SPEED_LIMIT: Final = "{robot} · {limit}"
HEADING: Final = "朝向"
SPEED: Final = "速度"
TURNING: Final = "转速"
GRIPPER: Final = "夹爪"
ARM: Final = "手臂"
ARM_WORDS: Final = {"up": "举起", "out": "伸出"}
OPEN: Final = "张开"
CLOSED: Final = "合上"
HALF_OPEN: Final = "半开"
AT_REST: Final = "静止"
MOVING: Final = "移动中"

# Microphone
MIC: Final = "话筒"
WOKEN: Final = {"serial": "被唤醒模块唤醒", "word": "被唤醒词唤醒"}
WOKEN_FROM: Final = "方向 {angle:.0f}°"
MIC_IDLE: Final = "未在聆听"
MIC_LOADING: Final = "启动中"
MIC_SPEECH: Final = "有人声"
MIC_QUIET: Final = "安静"
NO_MICROPHONE: Final = "没有麦克风：请输入，或用 sayso --demo 启动。"
DEAF: Final = {
    "microphone": "没有麦克风，听不到人说话：请打字",
    "recogniser": "语音识别不可用，听不懂人说话：请打字",
}

MIC_WAITING: Final = "无人声"
WAKE_BY: Final = {
    "key": "按键唤醒",
    "serial": "被模块唤醒",
    "word": "被唤醒词唤醒",
    "speech": "说话人继续说",
    "command": "被命令唤醒",
    "demo": "被演示唤醒",
    "file": "由文件开始",
}
LISTEN_ENDS: Final = {
    "silence": "话说完了",
    "max_length": "太长，已截断",
    "source_ended": "声音结束",
    "no_speech": "没有人说话",
    "cancelled": "被取消",
    "device_lost": "麦克风丢失",
}
SPEECH_FOR: Final = "人声 {seconds:.1f} 秒"
LOUDEST: Final = "最响 {db} dB"
COMMA: Final = "，"
SEMICOLON: Final = "；"
COLON: Final = "："
AND: Final = "和"
UNDERSTOOD: Final = "听懂了"
CONFIDENCE: Final = "置信度 {percent:.0f} %"

# Turns
STAGES: Final = {
    "wake": "唤醒",
    "record": "录音",
    "endpoint": "断句",
    "recognise": "识别",
    "decide": "决策",
    "plan": "规划",
    "act": "执行",
    "speak": "说话",
}
SINCE_SPEECH: Final = "从话说完起"
SINCE_REQUEST: Final = "从请求起"
STAGE_TO_MOTION: Final = "到运动"
STAGE_TO_ANSWER: Final = "到回答"
NO_TURNS: Final = "每个请求各阶段的用时会显示在这里。"
LISTENS: Final = "聆听中…"
RECOGNISES: Final = "识别中…"
NOTHING_SAID: Final = "还没有说什么"
TO_MOTION: Final = "{milliseconds} 到运动"
TO_ANSWER: Final = "{milliseconds} 到回答"
NEW_TURNS: Final = "{} 轮新的"
BROWSE: Final = "{turn_back} {turn_on} 翻看 · {turn} 打开"
TURN_TITLE: Final = "第 {number} 轮，共 {count} 轮"
TURN_KEYS: Final = "{turn_back} {turn_on} 翻看 · {unfold} {fold}详情 · {back} 返回 · {interrupt} 停止"
FOLD: Final = "折叠"
UNFOLD: Final = "展开"
NO_TURN: Final = "还没有任何一轮。"
OUTCOMES: Final = {
    "done": "完成",
    "failed": "失败",
    "clarify": "反问",
    "answered": "反问，已回答",
    "declined": "反问，已放弃",
    "replaced": "反问，已被取代",
    "withdrawn": "反问，已撤回",
    "no_order": "不是指令",
    "refused": "拒绝",
    "interrupted": "被打断",
    "timeout": "超时",
    "unheard": "没听到",
    "open": "进行中",
}
PART_SOUND: Final = "声音"
PART_WORDS_HEARD: Final = "听到"
PART_STAGES: Final = "阶段"
PART_THOUGHTS: Final = "思考"
PART_ACTIONS: Final = "动作"
PART_ANSWERS: Final = "回答"
PART_END: Final = "结果"
PART_REMARKS: Final = "备注"
THOUGHTS: Final = {
    "decision": "决定",
    "plan": "计划",
    "question": "反问",
    "refusal": "拒绝",
    "rejection": "没有计划",
}
UNCLEAR: Final = "不明确：{what}"
IN_JSON: Final = "JSON 形式的计划"
ASKED: Final = "询问"
LAYERS: Final = {"decision": "决策", "execution": "执行", "vision": "视觉"}
AGAIN: Final = "再次"
TOKENS: Final = "{prompt} → {reply} 词元"
BROKEN_OFF: Final = "被取消"
CAME_LATE: Final = "来得太晚"
TOO_LONG: Final = "被截断"
HEAD: Final = "固定开头，{length} 个字符（SHA-256 {digest}…）"
REPLY: Final = "答复"
NOTHING_CAME: Final = "无"
SAYS: Final = "说“{text}”"
HEARD_ALL: Final = "已听完"
HEARD_PART: Final = "说到“{heard}”被打断"
HEARD_NOTHING: Final = "还没出声就被打断"
ON_SCREEN: Final = "已显示"
CUT: Final = "{state}时被打断：{scope}"
CUT_BY: Final = "{state}时被打断：{scope}（{source}）"
LANGUAGE: Final = "语言 {language}"
DECODED: Final = "识别用时 {milliseconds}"
NO_SPEECH_SHARE: Final = "非人声 {percent:.0f} %"
LOG_PROBABILITY: Final = "对数概率 {value}"
SOUND_FIGURES: Final = "聆听 {listened:.1f} 秒 · 人声 {speech:.1f} 秒 · 峰值 {peak} dB"

# Input
PLACEHOLDER: Final = "按 {type} 输入机器人要做的事"
PLACEHOLDER_EARLY: Final = "按 {type} 输入；载入后才会执行：{parts}"
PLACEHOLDER_TYPING: Final = "输入机器人要做的事 · {earlier} 找回 · {recall} 搜索 · {back} 返回 · {interrupt} 停止"
PLACEHOLDER_TYPING_EARLY: Final = "输入；载入后才会执行：{parts} · {back} 返回 · {interrupt} 停止"
PLACEHOLDER_FAILED: Final = "什么都不会执行：引擎没有启动 · {leave_now} 退出"
PASTED_TOO_LONG: Final = "粘贴的内容太长：输入行最多 {} 个字符，没有接受任何内容。"
ADDS: Final = "{add} 排在后面"
NO_BORDER: Final = "那边没有可以再移动的边界"
NOTHING_TO_ADD: Final = "这一行是空的，没有可排的请求"
NO_USE: Final = {
    "queue": "没有等待的请求",
    "turn_back": "前面没有别的轮次",
    "turn_on": "后面没有别的轮次",
    "": "现在这样做没有作用",
}
PHRASES: Final = (
    "去", "向左转90度", "向右转90度", "转身", "前进1米", "后退1米", "你在哪里？", "你会做什么？", "你看到什么？",
    "看看四周", "拿起", "把它放到", "找到", "跟着我", "回来", "打扫房间", "举起手臂", "等5秒", "结束任务",
    "go to the ", "turn left 90 degrees", "turn right 90 degrees", "turn around", "move forward 1 metre",
    "move back 1 metre", "where are you?", "what can you do?", "what do you see?", "look around", "pick up the ",
    "follow me", "come back", "end the task",
)  # fmt: skip

# Log
SOURCES: Final = {
    "session": "会话",
    "engine": "引擎",
    "console": "控制台",
    "robot": "机器人",
    "microphone": "麦克风",
    "recogniser": "识别",
    "planner": "规划",
    "model": "模型",
    "vision": "视觉",
    "camera": "相机",
    "voice": "语音",
    "wake": "唤醒",
    "wake words": "唤醒词",
    "ros": "ROS图",
    "stop": "停止",
    "dispatch": "执行",
}

LOG_LEVELS: Final = {"debug": "全部", "info": "信息以上", "warning": "警告以上", "error": "只看错误"}
LOG_KEYS: Final = "{log_level} 级别 · {log_part} 部分 · {log_find} 搜索 · {log_trouble_before} 错误 · {log_turn} 该轮"
LOG_ALL: Final = "{log_all} 全部"
LOG_NOTHING_FITS: Final = "没有符合的 · {log_all} 显示全部"
NEW_LINES: Final = "{} 条新的"
SHOWS_NEW: Final = "{newest} 查看"
LINE_OF_NO_TURN: Final = "这一行不属于任何一轮。"

# Quitting and failing
NOTHING_TO_STOP: Final = "没有什么要停止 · {back} 返回"
NOT_PRESSED: Final = "急停没有按下"
PRESS_TAKEN_BACK: Final = "已取消：本控制台不会按下急停"
RELEASED: Final = "急停已解除"
ESTOP_NOT_KNOWN: Final = "还不知道急停是否按下：机器人就绪后再按一次"
NO_ESTOP: Final = "没有急停：引擎没有启动"
WITHDRAWN: Final = "问题已撤回"
WAITING_DROPPED: Final = {False: "取消了 {} 个等待的请求", True: "取消了 {} 个等待的请求"}
NOTHING_BACK: Final = "无处可返回 · {type} 转到输入行"
NOT_STARTED: Final = "未开始"
QUIT_QUESTION: Final = "任务进行中：再按 {leave} 退出，{interrupt} 停止任务"
QUIT_QUESTION_OPEN: Final = "还有没做完的请求：再按 {leave} 退出，{interrupt} 放弃它"
ENGINE_STARTING: Final = "引擎启动中…"
ENGINE_FAILED: Final = "引擎没有启动"
SESSION_ENDED: Final = "{leave} 退出；会话已结束：{reason}"
ENGINE_SILENT: Final = "引擎没有响应"
ABOUT_SILENT: Final = "它卡住了或被暂停。机器人没有引擎时会自己停下，现在已经停下。"
HINT_SILENT: Final = "{stop} 仍能停止机器人，{leave} 立即退出。其他键要等引擎恢复。"
PAUSED: Final = "{seconds:.1f} 秒没有响应"
ROBOT_BACK: Final = "机器人重新连上了"
HALTED: Final = "机器人自己停下了"
MOTION_PAUSED: Final = "可能有人说了“{phrase}”：机器人暂停"
MOTION_RESUMED: Final = "没有人说：机器人在 {seconds:.1f} 秒后继续（本次会话第 {number} 次误停）"
PROBLEM_KEYS: Final = "{back} 返回 · {interrupt} 停止"
SOMETHING_FAILED: Final = "出错了"
ASKED_EARLY: Final = "“{}”要等引擎启动后再发送。"
CRASH_WRITTEN: Final = "sayso：这是 sayso 的缺陷。请报告此事，并附上 {}"
CRASH_LOST: Final = "sayso：这是 sayso 的缺陷，详情没能保存：{}。"
CRASH_HINT: Final = "这是 sayso 的缺陷。请报告此事，并附上以上内容。"

# Help
HELP_TITLE: Final = "按键"
HELP_BEGIN: Final = "入门"
HELP_SEARCH: Final = "输入以搜索：按键，或其作用中的几个字"
HELP_REST: Final = "在输入行之外"
HELP_PANE: Final = "在此窗格：{}"
HELP_LINE: Final = "在输入行"
ABOUT_LINE_KEYS: Final = {
    "enter": "发送请求；粘贴的每一行是一条单独的请求。",
    "up,down": "找回以前的请求。",
    "tab": "采用建议；在空行中转到窗格。",
}
HELP_SIGNS: Final = "符号"
HELP_LEAVE: Final = "{newer} {older} 翻页 · {back} 返回 · {interrupt} 停止"
HELP_MAP: Final = "地图有键盘焦点时"
HELP_QUEUE: Final = "在动作窗格，有请求等待时"
HELP_LOG: Final = "日志有键盘焦点时"
HELP_DOCTOR: Final = "在检查页"
HELP_TURN: Final = "在一轮的详情页"
HELP_HAND: Final = "手动驾驶"
HELP_SETTINGS: Final = "在设置页"
SIGN_WORDS: Final = (
    ("○", "排队"),
    ("▸", "进行中"),
    ("✓", "完成"),
    ("✗", "失败"),
    ("■", "被打断"),
    ("?", "不确定"),
)

# Terminals
TOO_SMALL: Final = "sayso 至少需要 {min_columns}×{min_rows} 个字符（本终端为 {columns}×{rows}）。请放大终端。"
ONE_LINE: Final = "输入机器人要做的事。"
NO_ROOM_IN_LINE: Final = "这需要完整的控制台。"
TOO_SMALL_KEYS: Final = "{interrupt} 仍能停止机器人 · {leave_now} 退出"
TOO_SMALL_SHORT: Final = "{columns}×{rows} 太小"
STREAMS: Final = ("标准输入", "标准输出", "标准错误")
NOT_A_TERMINAL: Final = "控制台需要终端，而{stream}不是。程序请用 `sayso engine`，或用 `sayso ask TEXT`。"
DUMB_TERMINAL: Final = "控制台无法在此终端上绘制（TERM 为 {term}）。请换一个，或用只需文本行的 `sayso ask TEXT`。"

# Line to the terminal
LINK_DELAY: Final = "延迟 {}"
LINK_SILENT: Final = "延迟未知"
LINK_RATES: Final = "{:.1f} kB/s · {:.1f}/s"
FARES: Final = {
    "full": "终端连接恢复良好：显示全部内容。",
    "spare": "终端连接慢（每帧 {delay} ms）：减少帧数和画面。",
    "bare": "终端连接差（每帧 {delay} ms）：不显示相机、激光和轨迹，帧数很少。",
}
CAMERA_SPARED: Final = "没有画面：连接太差"
NO_CELL_SIZE: Final = (
    "相机画面用字符绘制：sixel 图像（console.camera_graphics）要知道一个字符有多少像素，而本终端没有说。"
)

# Keys that somebody chose
NO_ACTION: Final = "没有这个操作：{}"
DID_YOU_MEAN: Final = "是不是 {}？"
NO_KEY: Final = "没有给出按键；请写一个，如 `wake: w`，或删去这一行"
KEY_TAKEN: Final = "{key} 是 {other} 的键；请换一个，或给 {other} 也换一个"
KEY_IS_TYPED: Final = "{key} 要留给输入，因为这个键在输入时也起作用；请用 ctrl 加字母，或 f2"
KEY_IS_ANOTHER: Final = "终端分不清 {key} 和 {other}；请换一个"
KEY_NOT_PORTABLE: Final = "{key} 不是在每个终端都能用；请用字母、ctrl 加字母、f1 到 f12，或再加一个：`{key},x`"
KEY_UNKNOWN: Final = "{key} 不是按键；请写一个字符、pageup 或 f2 之类的名称，或 ctrl+x"
KEY_MISTAKE: Final = "console.keys.{action}：{message}。"
KEY_STAYS: Final = "{action} 仍用 {key}。"

# Palette
PALETTE: Final = "所有能做的事"
PALETTE_RECENT: Final = "以前提过的请求"
PALETTE_LOG: Final = "日志"
PALETTE_PROMPT: Final = "名称中的几个字"
PALETTE_KEYS: Final = "{send}执行 · {back} 返回 · {interrupt} 停止"
PALETTE_KEYS_FILL: Final = "{send}放进输入行 · {back} 返回 · {interrupt} 停止"
PASTED_LINES: Final = "粘贴了好几行，这里只能放一行，所以都没有放进来。"
NOTHING_FITS: Final = "没有匹配项"
NEAREST: Final = "没有匹配项；最接近的："
ASK_TYPED: Final = "向机器人提出：{}"
KIND_REQUEST: Final = "请求"
KIND_PLACE: Final = "地点"
KIND_SKILL: Final = "技能"
KIND_RECENT: Final = "以前"
KIND_MAP: Final = "地图"
KIND_QUEUE: Final = "动作"
KIND_LOG: Final = "日志"
KIND_DOCTOR: Final = "检查"
KIND_TURN: Final = "轮"
KIND_HAND: Final = "手动"
KIND_SETTINGS: Final = "设置"
SETTING_ENTRY: Final = "设置：{}"
VALUE_ENTRY: Final = "设置：{} → {}"
KIND_FILE: Final = "文件"
SETTINGS_FILE: Final = "设置在 {}"
SETTINGS_ARE_IN: Final = "设置写在 {}；`sayso config show` 列出它们，`sayso config check` 检查它们。"
FORM_KEYS: Final = "{send}：下一项，最后一项后执行 · {back} 返回 · {interrupt} 停止"
FORM_NUMBER: Final = "{low:g} 到 {high:g}"
FORM_WORDS: Final = "文字"
FORM_NO_NUMBER: Final = "{name} 必须是数字，如 1.5"
FORM_RANGE: Final = "{name} 必须是 {low:g} 到 {high:g} {unit}"
FORM_MISSING: Final = "缺少 {name}"
NOT_KEPT: Final = "你的请求没有保存到以后的会话：{}"

# Copying and saving
LINES: Final = ("{} 行", "{} 行")
COPIED: Final = "送往剪贴板：{part} · {lines} · 再按 {copy}：{other}"
NOTHING_TO_COPY: Final = "没有{part}可复制 · 再按 {copy}：{other}"
COPY_PARTS: Final = {
    "turn": "本轮",
    "conversation": "对话",
    "plan": "计划",
    "actions": "动作",
    "log": "日志",
}
SAVED: Final = "已保存在 {folder}"
SAVED_PICTURE: Final = "本次会话没有日志，只保存了截图：{folder}"

# Doctor
DOCTOR_TITLE: Final = "检查"
DOCTOR_KEYS: Final = "{older} {newer} 翻页 · {examine} 再检查 · {copy} 复制 · {back} 返回 · {interrupt} 停止"
EXAMINING: Final = "◌ {name} … 已检查 {count} 项"
NOTHING_TO_EXAMINE: Final = "设置尚未读取，请稍后再试。"
COPIED_PAGE: Final = "送往剪贴板：{lines}"
NOTHING_FOUND_YET: Final = "还没有可复制的"
FINDINGS: Final = {"ok": "正常", "limited": "受限", "missing": "缺少"}
CHECKS: Final = {
    "python": "Python",
    "recogniser": "语音识别",
    "voice activity": "语音检测",
    "reader": "理解器",
    "large model": "大模型",
    "microphone": "麦克风",
    "voice": "语音合成",
    "loudspeaker": "扬声器",
    "simulation": "仿真",
    "scheduling": "调度",
    "graphics": "图形",
    "robot": "机器人",
    "serial ports": "串口",
    "wake module": "唤醒模块",
    "wake words": "唤醒词",
    "ROS graph": "ROS图",
    "terminal": "终端",
    "event log": "事件日志",
}

# Devices
DEVICE_GONE: Final = {
    "robot": "与机器人的连接断开，机器人已停下，正在重新启动。",
    "microphone": "麦克风未连接。仍可打字。",
    "satellite": "语音卫星未连接。仍可打字。",
    "recogniser": "语音识别停止了。仍可打字。",
    "planner": "规划停止了，无法理解请求。{interrupt} 仍能停下机器人。",
    "voice": "机器人现在不能说话。回答只显示在屏幕上。",
    "camera": "相机未连接。仍可行驶，不能寻找和抓取。",
    "model": "本机的模型停止了。简单的命令仍可用。",
    "service": "有个模型没有回答。改问另一个，可能会慢一些。",
    "wake": "唤醒模块未连接 · {wake}键仍可唤醒",
    "wake words": "现在听不到唤醒词 · {wake}键仍可唤醒",
    "ros": "连不上ROS图。其他照常。",
}
DEVICE_BACK: Final = {
    "robot": "机器人重新连上了。",
    "microphone": "麦克风已连接，机器人能听见你。",
    "satellite": "语音卫星已连接，机器人能听见你。",
    "recogniser": "又能识别语音了。",
    "planner": "又能理解请求了。",
    "voice": "又能说话了。",
    "camera": "相机重新连上了。",
    "model": "本机的模型恢复了。",
    "service": "模型又有回答了。",
    "wake": "唤醒模块重新连上了。",
    "wake words": "又能听到唤醒词了。",
    "ros": "又连上ROS图了。",
}
DEVICE_LOOSE: Final = "几秒内通断了 {times} 次，请检查连接线。"

# Settings
UNKNOWN_THEME: Final = "没有主题 {!r}；控制台用自己的主题。"
DID_YOU_MEAN_THEME: Final = "是不是 {}？"
SETTINGS_TITLE: Final = "设置"
SETTINGS_KEYS: Final = (
    "{setting_take} 更改 · {setting_find} 搜索 · "
    "{setting_up}{setting_down} {setting_before}{setting_after} 查看 · {setting_default} 默认 · "
    "{back} 返回 · {interrupt} 停止"
)
SETTINGS_LINE: Final = "{send}保存所写内容 · {back} 返回 · {interrupt} 停止"
SETTINGS_FIND: Final = "名称或说明中的几个字 · {send}：到列表"
SETTING_GROUPS: Final = {
    "usual": "常用设置",
    "console": "控制台",
    "audio": "麦克风",
    "vad": "语音检测",
    "endpoint": "话音结束",
    "asr": "语音识别",
    "planner": "规划",
    "models": "模型",
    "voice": "语音",
    "wake": "唤醒",
    "robot": "机器人",
    "session": "会话",
    "ros": "ROS图",
}
SETTINGS_READING: Final = "正在读取设置……"
SETTINGS_NOT_READ: Final = "设置尚未读取，或有错误：`sayso config check` 会列出它们。"
SETTING_NAMES: Final = {
    "console.theme": "主题",
    "console.language": "语言",
    "console.fps": "每秒帧数",
    "console.camera": "相机",
    "console.camera_graphics": "相机画面",
    "console.motion": "动态效果",
    "console.notify": "通知",
    "voice.when": "语音",
    "voice.volume": "音量",
    "audio.device": "麦克风",
    "wake.words": "唤醒词",
    "planner.profile": "大模型",
}
SETTING_ABOUTS: Final = settings_zh.RARE | {
    "console.theme": "控制台的配色。左右键可以试看其他的。",
    "console.language": "屏幕文字的语言；auto：planner.language 为 zh 时用中文，否则按 LC_ALL、LC_MESSAGES 或 LANG。",
    "console.fps": "活动窗格每秒重画多少次。",
    "console.camera": "启动时是否显示相机画面；auto：终端够大且不经 SSH 时显示。",
    "console.camera_graphics": (
        "相机画面怎么画：blocks 用字符，sixel 和 kitty 用像素；"
        "auto：终端支持、线路良好且不在 tmux 或 screen 里时用像素。"
    ),
    "console.motion": "reduced：没有滑动，自行变化的内容（声音、时间、机器人）每秒只更新一次。",
    "console.notify": "auto：20秒以上的任务结束时，用桌面通知和响铃告知，除非终端报告它有键盘焦点；off：不通知。",
    "voice.when": "哪些回答会说出来：spoken 只回答口头请求，always 也回答键入的请求，never 都不说。",
    "voice.volume": "语音和提示音的音量，0 到 1。",
    "audio.device": "麦克风的名称（或一部分）或编号，或卫星设备 tcp://HOST:PORT；不写：系统默认。",
    "wake.words": "唤醒词（`sayso wake list`），用逗号隔开；auto：已安装的 hey jarvis 和 hey sayso。",
    "planner.profile": "还用哪些大模型思考（profiles.yaml）：phrases（不用）、local、international、china，或自己的。",
}
SETTING_VALUES: Final = {"en": "en · English", "zh": "zh · 中文", "true": "开", "false": "关"}
NO_VALUE: Final = "未设置"
NO_ENTRY: Final = "无"
FROM_DEFAULT: Final = "默认"
SETTING_LIVE: Final = "立即生效。"
SETTING_RESTART: Final = "重新启动 sayso 后生效。"
SETTING_KEPT: Final = "✓ {name}：已保存在 {file}。"
SETTING_BACK: Final = "✓ {name}：已是 sayso 自带的值。"
SETTING_OVER: Final = "{origin} 覆盖了文件：去掉它之前，{value} 一直有效。"
