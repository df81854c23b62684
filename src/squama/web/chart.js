// A plot by ECharts. It is given its options as they came: read through Vue's proxies they take several times as long.
import { echarts } from "nicegui-echart";
import { toRaw } from "vue";

export default {
  props: { options: Object, renderer: String },
  emits: ["picked"],
  template: `<div class="chart" role="img"></div>`,
  mounted() {
    this.chart = echarts.init(this.$el, null, { renderer: this.renderer });
    this.chart.on("click", ({ value, seriesId }) => this.$emit("picked", { value, seriesId }));
    this.watched = new ResizeObserver(() => this.chart.resize());
    this.watched.observe(this.$el);
    this.draw();
  },
  beforeUnmount() {
    this.watched.disconnect();
    this.chart.dispose();
  },
  watch: { options: "draw" },
  methods: {
    draw() {
      const options = toRaw(this.options);
      // lines that are there no more go only with all the others
      const lines = options.series.length;
      this.chart.setOption(options, { notMerge: lines !== this.lines });
      this.lines = lines;
    },
  },
};
